"""Checks that hold for the mock and for the real service alike."""

import time
import urllib.request

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select

POLICY = {
    "default-src 'none'", "script-src 'self'", "style-src 'self'", "img-src 'self' data:",
    "connect-src 'self'", "base-uri 'none'", "form-action 'none'", "frame-ancestors 'none'",
}
SKIPPED = object()
STATES = {"No data", "Settling", "Healthy", "Alarm", "Stale data", "Failed"}


def load(browser, url, token=None):
    """Opens the page and waits until it is live."""
    browser.open(url)
    if token is not None:
        browser.until("the token is asked for", lambda: browser.js("return document.getElementById('token').open"))
        browser.keys(token, Keys.ENTER)
    browser.until("live", lambda: browser.js("return document.body.dataset.connection") == "live", 15)
    browser.until("a machine", lambda: browser.all("#machine-rows tr"), 15)
    browser.until("charts", lambda: browser.all("#charts canvas"), 15)


def served_with_the_policy(browser, url, **_):
    with urllib.request.urlopen(url, timeout=5) as answer:
        found = {part.strip() for part in answer.headers["Content-Security-Policy"].split(";")}
        body = answer.read().decode()
    assert found == POLICY, f"the policy is {found ^ POLICY} off"
    assert "style=" not in body and "onclick" not in body, "inline style or script"
    return f"{len(POLICY)} directives"


def loads_quietly(browser, url, token, **_):
    load(browser, url, token)
    time.sleep(2)
    browser.assert_quiet(but=("401 (Unauthorized)",) if token else ())
    words = browser.js("return [...document.querySelectorAll('#machine-rows .state')].map((own) => own.textContent)")
    assert words and set(words) <= STATES, f"states {words}"
    assert browser.text("#clock").endswith(("CET", "CEST")), browser.text("#clock")
    return f"{len(words)} machines"


def follows_the_samples(browser, **_):
    seconds = "return document.querySelector('#machine-facts div:last-child dd').textContent"
    first = browser.js(seconds)
    took = browser.until("another last sample", lambda: browser.js(seconds) != first, 5)
    return f"{took:.1f} s"


def charts_are_drawn_sharp(browser, **_):
    browser.look(1400, "light", ratio=2)
    time.sleep(1)
    found = browser.js(
        "const own = document.querySelector('#charts canvas');"
        "const pixels = own.getContext('2d').getImageData(0, 0, own.width, own.height).data;"
        "const colours = new Set(); for (let at = 0; at < pixels.length; at += 4)"
        "  colours.add(pixels[at] + 256 * pixels[at + 1] + 65536 * pixels[at + 2]);"
        "return [own.width / own.clientWidth, colours.size]"
    )
    browser.look(1400, "light")
    assert abs(found[0] - 2) < 0.02, f"{found[0]} pixels of the drawing a pixel of the page, expected 2"
    assert found[1] > 10, f"{found[1]} colours: nothing is drawn"
    return f"{found[1]} colours"


def charts_are_read_by_keys(browser, **_):
    valuetext = "return document.activeElement.getAttribute('aria-valuetext')"
    browser.js("document.querySelector('#charts .plot[tabindex=\"0\"]').focus()")
    stops = browser.js("return document.querySelectorAll('#charts .plot[tabindex=\"0\"]').length")
    assert stops == 1, f"{stops} charts are in the order of Tab, expected one"
    browser.keys(Keys.ARROW_LEFT)
    browser.until("a time is read", lambda: "CE" in browser.js(valuetext) and browser.text("#cursor"))
    first = browser.js(valuetext)
    browser.keys(*[Keys.ARROW_LEFT] * 5)
    browser.until("an earlier value", lambda: browser.js(valuetext) != first)
    name = browser.focus()
    browser.keys(Keys.ARROW_DOWN)
    assert browser.focus() != name, "the arrow down stays on a chart"
    browser.keys("+")
    browser.until("the zoom is told", lambda: browser.shown("#held"))
    browser.keys("0")
    browser.until("the whole", lambda: not browser.shown("#held"))
    browser.keys(Keys.ESCAPE)
    browser.until("no cursor", lambda: browser.text("#cursor") == "")
    return first


def charts_zoom_by_a_drag(browser, **_):
    canvas = browser.one("#charts .plot")
    browser.js("arguments[0].scrollIntoView({ block: 'center' })", canvas)
    drag = ActionChains(browser.driver).move_to_element_with_offset(canvas, -40, 0)
    drag.click_and_hold().move_by_offset(80, 0).release().perform()
    browser.until("the zoom is told", lambda: browser.shown("#held"))
    text = browser.text("#held-text")
    browser.click(browser.one("#live"))
    browser.until("live again", lambda: not browser.shown("#held"))
    assert browser.focus() == browser.text("#spans [aria-pressed=true]"), browser.focus()
    return text


def spans_are_read(browser, **_):
    for label in ("1 h", "2 min", "10 min"):
        browser.click(next(button for button in browser.all("#spans button") if button.text == label))
        browser.until(label, lambda: browser.text("#spans [aria-pressed=true]") == label)
        time.sleep(0.5)
        assert not browser.shown("#trend-notes button"), browser.text("#trend-notes")
    return "1 h, 2 min, 10 min"


def fits_narrow_and_wide(browser, shots, **_):
    for more in browser.all("#alarm-rows .more")[:1]:
        browser.click(more)
    for width in (320, 400, 600, 800, 900, 1100, 1239, 1240, 1300, 1400, 1920):
        browser.look(width, "light", height=860)
        time.sleep(0.4)
        wide = browser.js("return document.documentElement.scrollWidth")
        assert wide <= width, f"{wide} px of page in a window of {width}"
        small = browser.js(
            "return [...document.querySelectorAll('button, select, input')].filter((own) => own.offsetParent"
            " && own.type !== 'checkbox' && !own.classList.contains('more')"
            " && own.getBoundingClientRect().height < 24).map((own) => own.textContent || own.name || own.id)"
        )
        assert small == [], f"less than 24 px high: {small}"
    for width in (1400, 400):
        for scheme in ("light", "dark"):
            browser.look(width, scheme, height=1000 if width > 600 else 860, ratio=1 if width > 600 else 2)
            browser.js("scrollTo(0, 0)")
            time.sleep(0.8)
            if shots:
                browser.shot(shots / f"page-{width}-{scheme}.png")
    browser.look(1400, "light")
    return "320 to 1920 px"


def passes_axe(browser, axe, **_):
    if axe is None:
        return SKIPPED
    browser.js(axe.read_text())
    passed = []

    def run(what):
        time.sleep(0.5)
        found = browser.driver.execute_async_script(
            "const done = arguments[0];"
            "axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'] })"
            ".then((own) => done([own.violations.map((each) => [each.id,"
            " each.nodes.map((node) => node.target + ': ' + node.any.map((any) => any.message))]),"
            " own.passes.length]))"
        )
        assert found[0] == [], f"{what}: {found[0]}"
        passed.append(found[1])

    for width in (1400, 400):
        for scheme in ("light", "dark"):
            browser.look(width, scheme)
            browser.js("scrollTo(0, 0)")
            run(f"{width} px, {scheme}")
            for place in (1, 2, 0):
                browser.click(browser.all("#alarm-lists button")[place])
                browser.js("scrollTo(0, 0)")
                run(f"{width} px, {scheme}, list {place}")
            for action in [own for own in browser.all("#alarm-rows .actions button") if own.is_displayed()][:2]:
                browser.click(action)
                run(f"{width} px, {scheme}, dialog")
                browser.keys(Keys.ESCAPE)
    browser.look(1400, "light")
    return f"{len(passed)} views, up to {max(passed)} rules, no violation"


def fault_is_followed(browser, try_fault, **_):
    """From the panel of the embedded turbine to an acknowledged alarm."""
    if try_fault is None:
        return SKIPPED
    known = {own.get_attribute("data-alarm") for own in browser.all("#alarm-rows tr[data-alarm]")}
    Select(browser.one("#faults select")).select_by_visible_text("Thermocouple drift")
    for name, value in (("rate_per_h", "600"), ("limit", "5")):
        browser.one(f"#faults [name={name}]").clear()
        browser.one(f"#faults [name={name}]").send_keys(value)
    browser.click(browser.one("#faults form button"))
    browser.until("the fault is listed", lambda: "Thermocouple drift" in browser.text("#faults li"), 10)

    def new():
        rows = browser.all("#alarm-rows tr[data-alarm]")
        return [own for own in rows if own.get_attribute("data-alarm") not in known]

    took = browser.until("an alarm", new, try_fault)
    assert "New alarm: " in browser.text("#alert"), browser.text("#alert")
    number = new()[0].get_attribute("data-alarm")
    row = f'#alarm-rows tr[data-alarm="{number}"]'
    browser.click(browser.one(f"{row} .actions button"))
    browser.keys("Test", Keys.TAB, "seen by the test of the page", Keys.TAB, Keys.ENTER)
    browser.until("acknowledged", lambda: "Active, acknowledged" in browser.text(row), 10)
    found = browser.text(f"{row} .more")
    browser.click(browser.one("#faults > button"))
    browser.until("the fault is gone", lambda: not browser.all("#faults li"), 10)
    return f"{found} after {took:.1f} s"


def asks_only_its_origin(browser, url, **_):
    browser.collect()
    foreign = [own for own in browser.requests if not own.startswith((url, "data:", "about:"))]
    assert foreign == [], f"asked {foreign}"
    assert len(browser.requests) > 20, "too few requests were seen to say anything"
    return f"{len(browser.requests)} requests"


CHECKS = [
    served_with_the_policy, loads_quietly, follows_the_samples, charts_are_drawn_sharp,
    charts_are_read_by_keys, charts_zoom_by_a_drag, spans_are_read, fault_is_followed, fits_narrow_and_wide, passes_axe,
]
LAST = [asks_only_its_origin]
