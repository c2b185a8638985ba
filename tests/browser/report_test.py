"""Opens reports in headless Chromium: quiet, self-contained, readable, and charts that zoom.

    python -m venv V && V/bin/pip install selenium
    V/bin/python report_test.py out/index.html [more/index.html ...] [--shots FOLDER]
"""

import argparse
import shutil
import sys
from pathlib import Path

sys.dont_write_bytecode = True

from browser import Browser
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

#: Bytes of a page at most.
MOST_BYTES = 5_000_000


def ticks(browser, figure):
    """What is written along the axes of a chart."""
    script = "return [...arguments[0].querySelectorAll('.view > text:not(.marktext)')].map((own) => own.textContent)"
    return browser.js(script, figure)


def alone(browser, path):
    """Nothing is fetched but the file itself."""
    browser.collect()
    outside = [url for url in browser.requests if not url.startswith((path.as_uri(), "data:", "about:"))]
    assert outside == [], f"asks for {outside}"
    browser.assert_quiet()


def narrow(browser, path, shots):
    """The page is no wider than the window, at any width and in both themes."""
    for width, scheme in ((1400, "light"), (1400, "dark"), (400, "light"), (400, "dark")):
        browser.look(width, scheme)
        browser.driver.get(path.as_uri())
        wide = browser.js("return document.documentElement.scrollWidth")
        assert wide <= width, f"{wide} px at {width}"
        if shots:
            browser.whole(shots / f"{path.parent.name}_{width}_{scheme}.png")
    browser.look(1400, "light")
    browser.driver.get(path.as_uri())


def visible_charts(browser):
    return [figure for figure in browser.all("figure") if figure.is_displayed()]


def drag(browser, figure, start, end):
    """Drags over a chart, from and to shares of its width."""
    svg = figure.find_element("css selector", "svg")
    browser.js("arguments[0].scrollIntoView({ block: 'center' })", svg)
    width, height = svg.size["width"], svg.size["height"]
    # Offsets count from the middle.
    x = [(own - 0.5) * width for own in (start, end)]
    chain = ActionChains(browser.driver)
    chain.move_to_element_with_offset(svg, x[0], 0.1 * height).click_and_hold()
    chain.move_to_element_with_offset(svg, x[1], 0.1 * height + 2).release().perform()


def zooms(browser):
    """A drag shows a part, the keyboard and a double click all again; charts over one time agree."""
    figures = visible_charts(browser)
    wide = [own for own in figures if own.find_elements("css selector", "svg.live:not(.square)")]
    if not wide:
        return
    first = wide[0]
    before = ticks(browser, first)
    others = [(own, ticks(browser, own)) for own in wide[1:]]
    drag(browser, first, 0.4, 0.6)
    after = ticks(browser, first)
    assert after != before, "a drag did not zoom"
    label = "return JSON.parse(arguments[0].querySelector('script').textContent)"
    own = browser.js(label, first)
    for figure, old in others:
        data = browser.js(label, figure)
        same = data["x_label"] == own["x_label"] and data["axes"][0] == own["axes"][0]
        assert (ticks(browser, figure) != old) == same, "charts over one time do not agree"
    svg = first.find_element("css selector", "svg")
    browser.js("arguments[0].focus()", svg)
    browser.keys(Keys.ESCAPE)
    assert ticks(browser, first) == before, "Escape does not show all"
    browser.keys("+")
    assert ticks(browser, first) != before, "+ does not zoom"
    browser.keys("0")
    assert ticks(browser, first) == before, "0 does not show all"
    drag(browser, first, 0.2, 0.5)
    ActionChains(browser.driver).move_to_element(svg).double_click().perform()
    assert ticks(browser, first) == before, "a double click does not show all"


def agrees(browser):
    """Drawn anew by the script, a chart has the ticks that it came with."""
    for figure in visible_charts(browser):
        if not figure.find_elements("css selector", "svg.live"):
            continue
        before = ticks(browser, figure)
        svg = figure.find_element("css selector", "svg")
        browser.js("arguments[0].focus()", svg)
        browser.keys("0")
        assert ticks(browser, figure) == before, (before, ticks(browser, figure))


def reads(browser):
    """Under the pointer stand the values."""
    for figure in visible_charts(browser)[:3]:
        svgs = figure.find_elements("css selector", "svg.live:not(.square)")
        if not svgs:
            continue
        browser.js("arguments[0].scrollIntoView({ block: 'center' })", svgs[0])
        ActionChains(browser.driver).move_to_element(svgs[0]).perform()
        text = figure.find_element("css selector", ".readout").text
        assert any(own.isdigit() for own in text), f"the readout says {text!r}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", type=Path, nargs="+")
    parser.add_argument("--shots", type=Path, help="folder for pictures of the pages")
    parser.add_argument("--chromium", default=shutil.which("chromium"))
    parser.add_argument("--chromedriver", default=shutil.which("chromedriver"))
    given = parser.parse_args()
    if given.shots:
        given.shots.mkdir(parents=True, exist_ok=True)
    browser = Browser(given.chromium, given.chromedriver)
    try:
        for page in given.pages:
            path = page.resolve()
            size = path.stat().st_size
            assert size < MOST_BYTES, f"{page}: {size} bytes"
            browser.requests.clear()
            browser.driver.get(path.as_uri())
            alone(browser, path)
            narrow(browser, path, given.shots)
            agrees(browser)
            zooms(browser)
            reads(browser)
            alone(browser, path)
            print(f"ok  {page}: {len(browser.all('figure'))} charts, {size} bytes", flush=True)
    finally:
        browser.close()


if __name__ == "__main__":
    main()
