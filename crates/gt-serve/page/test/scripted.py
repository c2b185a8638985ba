"""Checks against the mock, which does what each of them needs."""

import time

import plant
from anywhere import load
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select

ALERTS = "return [...document.querySelectorAll('#alert p')].map((own) => own.textContent)"
DIALOG = "return document.getElementById(arguments[0]).open"


def row(number, rest=""):
    return f'#alarm-rows tr[data-alarm="{number}"] {rest}'.strip()


def button(browser, number, label):
    found = [own for own in browser.all(row(number, "button")) if own.text.startswith(label) and own.is_displayed()]
    assert found, f"alarm {number} has no button {label}"
    return found[0]


def fresh(browser, mock):
    """The plant as in the beginning, and a fresh page of it."""
    mock.machines, mock.alarms = plant.machines(), plant.alarms()
    mock.posts.clear()
    mock.broken.clear()
    mock.slow.clear()
    load(browser, mock.url)
    browser.until("the alarms", lambda: browser.all(row(101)))


def strings_stay_text(browser, mock):
    fresh(browser, mock)
    mock.put_alarm(plant.alarm(200, "GT-06 " + plant.HOSTILE, fault=plant.HOSTILE, finding="named", unit=plant.HOSTILE,
                               magnitude=1.0, source=plant.HOSTILE, detector=plant.HOSTILE))
    browser.until("the alarm", lambda: browser.all(row(200)))
    browser.click(browser.one(row(200, ".more")))
    browser.click(browser.one(row(200, "a")))
    browser.until("its machine", lambda: plant.HOSTILE in browser.text("#machine-title"))
    browser.until("the reason", lambda: plant.HOSTILE in browser.text("#machine-reason"))
    browser.click(button(browser, 200, "Shelve"))
    assert plant.HOSTILE in browser.text("#shelve .subject")
    browser.keys(Keys.ESCAPE)
    for place in (1, 2):
        browser.click(browser.all("#alarm-lists button")[place])
    browser.until("the history", lambda: browser.all(row(90)))
    browser.click(browser.one(row(90, ".more")))
    browser.until("its comment", lambda: plant.HOSTILE in browser.text("#alarm-rows .events"))
    found = browser.js("return document.querySelectorAll('img, [onerror], script:not([src])').length")
    assert found == 0, f"{found} elements came out of texts"
    said = browser.js(ALERTS)
    assert any(plant.HOSTILE in text for text in said), said


def acknowledged_by_clicks(browser, mock):
    fresh(browser, mock)
    browser.click(button(browser, 101, "Acknowledge"))
    browser.one("#acknowledge [name=by]").send_keys("Jo Müller")
    browser.one("#acknowledge [name=comment]").send_keys("seen; \"fuel\" valve <3")
    browser.click(browser.one("#acknowledge .main"))
    browser.until("closed", lambda: not browser.js(DIALOG, "acknowledge"))
    expected = [("101/acknowledge", {"by": "Jo Müller", "comment": "seen; \"fuel\" valve <3"})]
    assert mock.posts == expected, mock.posts
    browser.until("acknowledged", lambda: "Active, acknowledged" in browser.text(row(101)))
    assert not [own for own in browser.all(row(101, "button")) if own.text == "Acknowledge" and own.is_displayed()]
    assert "Thermocouple drift" in browser.focus(), f"the focus is on {browser.focus()!r}"


def shelved_and_unshelved_by_clicks(browser, mock):
    fresh(browser, mock)
    browser.click(button(browser, 101, "Shelve"))
    browser.one("#shelve [name=reason]").send_keys("thermocouple is being changed")
    Select(browser.one("#shelve [name=minutes]")).select_by_visible_text("4 hours")
    assert browser.text("#shelve .until").startswith("until ")
    browser.one("#shelve [name=by]").send_keys("Jo")
    browser.click(browser.one("#shelve .main"))
    browser.until("gone from the open ones", lambda: not browser.all(row(101)))
    body = {"reason": "thermocouple is being changed", "minutes": 240, "by": "Jo"}
    assert mock.posts == [("101/shelve", body)], mock.posts
    browser.click(browser.all("#alarm-lists button")[1])
    browser.until("on the shelf", lambda: "shelved until" in browser.text(row(101)))
    browser.click(button(browser, 101, "Unshelve"))
    assert browser.one("#unshelve [name=by]").get_attribute("value") == "Jo", "the name is not remembered"
    browser.keys(Keys.ENTER)
    browser.until("off the shelf", lambda: not browser.all(row(101)))
    assert mock.posts[1:] == [("101/unshelve", {"by": "Jo"})], mock.posts


def all_by_keys_alone(browser, mock):
    fresh(browser, mock)
    browser.keys(Keys.TAB)
    assert browser.focus() == "Skip to the alarms", browser.focus()
    browser.keys(Keys.ENTER)
    browser.tab_to("Acknowledge Thermocouple drift, GT-01", 20)
    outline = browser.js("return getComputedStyle(document.activeElement).outlineStyle")
    assert outline != "none", "the focus cannot be seen"
    browser.keys(Keys.ENTER)
    assert browser.js(DIALOG, "acknowledge") and browser.focus() == "by", browser.focus()
    browser.keys(Keys.ENTER)
    assert browser.js(DIALOG, "acknowledge") and mock.posts == [], "sent without a name"
    browser.keys("   ", Keys.ENTER)
    assert browser.js(DIALOG, "acknowledge") and mock.posts == [], "sent with blanks for a name"
    browser.keys(Keys.BACKSPACE * 3, "Kim", Keys.TAB, "on my way", Keys.TAB, Keys.ENTER)
    browser.until("sent", lambda: mock.posts == [("101/acknowledge", {"by": "Kim", "comment": "on my way"})])
    browser.until("closed", lambda: not browser.js(DIALOG, "acknowledge"))
    browser.tab_to("Shelve… Thermocouple drift, GT-01", 20)
    browser.keys(Keys.SPACE)
    browser.keys("calibration", Keys.TAB, "3", Keys.TAB, Keys.TAB, Keys.ENTER)
    browser.until("shelved", lambda: len(mock.posts) == 2)
    body = {"reason": "calibration", "minutes": 30, "by": "Kim"}
    assert mock.posts[1] == ("101/shelve", body), mock.posts[1]
    browser.tab_to("GT-02", 60)
    browser.keys(Keys.ENTER)
    browser.until("the machine", lambda: browser.text("#machine-title") == "GT-02")


def new_alarm_is_heard(browser, mock):
    fresh(browser, mock)
    assert browser.js(ALERTS) == [], "alarms of before are called new"
    own = plant.alarm(300, "GT-02", severity=900)
    began = time.monotonic()
    mock.put_alarm(own)
    text = "New alarm: Fault not yet identified, GT-02, severity 900."
    browser.until("heard", lambda: browser.js(ALERTS) == [text], 1)
    took = time.monotonic() - began
    browser.until("in the list", lambda: browser.all(row(300)), 1)
    browser.until("in the title", lambda: browser.driver.title.startswith("(3) "), 2)
    at = plant.now_ms()
    mock.put_alarm({**own, **plant.named("turbine_damage", at - 60_000, 1.2, "%", 0.93)}, "named")
    browser.until("its name", lambda: browser.js(ALERTS)[1:] == ["Alarm of GT-02 is now: Turbine damage."], 1)
    mock.put_alarm({**mock.alarms["300"], "state": "normal", "ended_ms": at}, "cleared")
    browser.until("cleared", lambda: not browser.all(row(300)), 1)
    browser.until("told", lambda: "Alarm cleared: Turbine damage, GT-02." in browser.text("#status"), 1)
    return f"{took:.2f} s"


def focus_outlives_updates(browser, mock):
    fresh(browser, mock)
    browser.one("#find-tag").send_keys("t3")
    browser.until("two charts", lambda: len([own for own in browser.all("#charts .card") if own.is_displayed()]) == 2)
    browser.js("arguments[0].focus()", button(browser, 102, "Shelve"))
    for number in range(400, 406):
        mock.put_alarm(plant.alarm(number, "GT-02", severity=950))
        time.sleep(0.3)
    assert browser.focus() == "Shelve… Compressor fouling, GT-02", browser.focus()
    assert browser.one("#find-tag").get_attribute("value") == "t3"
    return "6 alarms"


def fields(browser):
    """What stands in the dialog that shelves."""
    return {own.get_attribute("name"): own.get_attribute("value") for own in browser.all("#shelve [name]")}


def nothing_typed_is_lost(browser, mock):
    fresh(browser, mock)
    browser.click(button(browser, 101, "Shelve"))
    browser.keys("a long reason", Keys.TAB, Keys.TAB, "Kim")
    mock.broken["alarms/101/shelve"] = (503, "the log is full: make room on the disk")
    browser.keys(Keys.ENTER)
    wanted = "Not done: the log is full: make room on the disk."
    browser.until("the error", lambda: browser.text("#shelve .failure").strip() == wanted)
    mock.broken.clear()
    browser.keys(Keys.ESCAPE)
    assert not browser.js(DIALOG, "shelve")
    browser.click(button(browser, 101, "Shelve"))
    typed = {"reason": "a long reason", "minutes": "60", "by": "Kim"}
    assert fields(browser) == typed, fields(browser)
    mock.slow["alarms/101/shelve"] = 13
    browser.click(browser.one("#shelve .main"))
    browser.until("it is slow", lambda: browser.text("#shelve .failure") == "No answer yet. Still waiting…", 3)
    took = browser.until("out of time", lambda: "did not answer within 10 s" in browser.text("#shelve .failure"), 12)
    assert fields(browser) == typed, fields(browser)
    assert mock.posts == [], mock.posts
    mock.slow.clear()
    browser.click(browser.one("#shelve .main"))
    browser.until("sent", lambda: mock.posts == [("101/shelve", {**typed, "minutes": 60})])
    browser.until("closed", lambda: not browser.js(DIALOG, "shelve"))
    browser.until("the late one", lambda: len(mock.posts) == 2, 15)
    return f"told after {2 + took:.0f} s"


def no_sample_is_lost_while_a_trend_is_read(browser, mock):
    fresh(browser, mock)
    mock.late_s = 2.5
    browser.click(browser.one("#spans button"))
    browser.until("2 min", lambda: browser.text("#key-band") == "least to most in 200 ms", 8)
    mock.late_s = 0.0
    time.sleep(1)
    browser.js("document.querySelector('#charts .plot[tabindex=\"0\"]').focus()")
    read = []
    for _ in range(40):
        browser.keys(Keys.ARROW_LEFT)
        time.sleep(0.28)
        read.append(browser.js("return document.activeElement.getAttribute('aria-valuetext')"))
    assert len(set(read)) > 20, read
    seconds = sorted({int(text.split(" CET")[0][-2:]) for text in read})
    steps = {(two - one) % 60 for one, two in zip(seconds, seconds[1:] + seconds[:1])}
    # One step of the circle of 60 leads from the last to the first.
    assert sorted(steps)[:-1] == [1], f"seconds {seconds}"


def failed_readings_are_told(browser, mock):
    mock.broken["machines/GT-01/trend"] = (500, "no memory")
    mock.broken["alarms/101/events"] = (500, "log unreadable")
    mock.machines, mock.alarms = plant.machines(), plant.alarms()
    browser.open(mock.url)
    wanted = "The trends of GT-01 could not be read: no memory.Try again"
    browser.until("the trend's error", lambda: browser.text("#trend-notes") == wanted)
    browser.until("the alarms all the same", lambda: browser.all(row(101)))
    browser.click(browser.one(row(101, ".more")))
    browser.until("the events' error", lambda: "could not be read: log unreadable" in browser.text(".events"))
    mock.broken.clear()
    browser.click(browser.one(".events button"))
    browser.until("events", lambda: browser.all(".events tbody tr"))
    browser.click(browser.one("#trend-notes button"))
    browser.until("charts", lambda: browser.all("#charts canvas"))
    assert browser.text("#trend-notes") == ""
    mock.broken["machines"] = (500, "not now")
    browser.open(mock.url)
    wanted = "Alarms and machines could not be read: not now. The next try is in 5 s."
    browser.until("that nothing could be read", lambda: browser.text("#alarm-notes") == wanted)
    mock.broken.clear()
    browser.until("live by itself", lambda: browser.js("return document.body.dataset.connection") == "live", 12)
    browser.until("no note", lambda: browser.text("#alarm-notes") == "")


def lost_connection_is_shown(browser, mock, shots=None):
    fresh(browser, mock)
    mock.stop()
    lost = browser.until("told", lambda: browser.shown("#banner"), 3)
    assert browser.text("#banner").startswith("No connection since "), browser.text("#banner")
    assert browser.js("return getComputedStyle(document.querySelector('main')).filter") == "grayscale(1)"
    assert any(text.startswith("No connection since ") for text in browser.js(ALERTS))
    browser.until("in the title", lambda: browser.driver.title.startswith("No connection"), 2)
    assert browser.all(row(101)), "what was known is gone"
    browser.click(button(browser, 101, "Acknowledge"))
    browser.keys("Kim", Keys.ENTER)
    browser.until("the error", lambda: "cannot be reached" in browser.text("#acknowledge .failure"))
    browser.keys(Keys.ESCAPE)
    time.sleep(2)
    if shots:
        browser.shot(shots / "page-1400-no-connection.png")
    mock.alarms["500"] = plant.alarm(500, "GT-03 cogeneration", severity=700)
    mock.start()
    back = browser.until("live again", lambda: not browser.shown("#banner"), 12)
    text = "New alarm: Fault not yet identified, GT-03 cogeneration, severity 700."
    browser.until("the alarm of meanwhile", lambda: text in browser.js(ALERTS))
    assert browser.js("return getComputedStyle(document.querySelector('main')).filter") == "none"
    browser.until("told", lambda: "Connected again after " in browser.text("#status"))
    return f"seen after {lost:.1f} s, live {back:.1f} s after the service"


def silence_is_a_lost_connection(browser, mock):
    fresh(browser, mock)
    mock.silent = True
    took = browser.until("told", lambda: "nothing was heard from the service for 25 s" in browser.text("#banner"), 28)
    mock.silent = False
    browser.until("live again", lambda: not browser.shown("#banner"), 12)
    return f"{took:.0f} s"


def left_out_updates_are_told(browser, mock):
    fresh(browser, mock)
    mock.send("dropped", {"count": 12})
    mock.send("unheard", {"of": 1})
    for stream in mock.streams:
        stream.put("event: alarm\ndata: {spoilt\n\n")
    browser.until("told", lambda: "12 updates left out" in browser.text("#about"), 3)


def history_is_read(browser, mock):
    fresh(browser, mock)
    browser.click(browser.all("#alarm-lists button")[2])
    browser.until("the past", lambda: browser.all(row(90)) and browser.all(row(91)))
    assert not browser.all(row(101)) and not browser.all("#alarm-rows .actions button:not([hidden])")
    Select(browser.one("#history-machine")).select_by_visible_text("GT-02")
    browser.until("of one machine", lambda: browser.all(row(91)) and not browser.all(row(90)))
    Select(browser.one("#history-span")).select_by_visible_text("24 hours")
    browser.until("of one day", lambda: browser.text("#alarm-none") == "No alarm in this time." and browser.shown("#alarm-none"))


def faults_are_tried(browser, mock):
    fresh(browser, mock)
    Select(browser.one("#faults select")).select_by_visible_text("Fuel actuator lag")
    rate = browser.one("#faults [name=rate_per_h]")
    rate.clear()
    rate.send_keys("12.5", Keys.ENTER)
    body = {"case": "fuel_actuator_lag", "rate_per_h": 12.5, "limit": 1}
    browser.until("sent", lambda: mock.posts == [("faults", body)])
    browser.until("listed", lambda: "Fuel actuator lag" in browser.text("#faults li"))
    browser.click(browser.one("#faults > button"))
    browser.until("removed", lambda: not browser.all("#faults li"))
    assert mock.posts[1:] == [("faults", None)], mock.posts


def roles_see_what_they_may_use(browser, mock):
    try:
        for role, buttons, faults in (("read", False, False), ("operate", True, False), ("administer", True, True)):
            mock.role = role
            fresh(browser, mock)
            assert browser.shown("#alarm-rows .actions button") == buttons, role
            assert browser.shown("#faults") == faults, role
    finally:
        mock.role = "administer"


def token_is_asked_for(browser, mock):
    mock.token = "secret-1"
    try:
        browser.open(mock.url)
        browser.until("asked", lambda: browser.js(DIALOG, "token"))
        browser.keys(Keys.ESCAPE)
        browser.keys(Keys.ESCAPE)
        browser.until("still asked", lambda: browser.js(DIALOG, "token"))
        browser.one("#token input").send_keys("wrong", Keys.ENTER)
        browser.until("refused", lambda: "refused the token" in browser.text("#token .failure"))
        browser.one("#token input").send_keys("secret-1", Keys.ENTER)
        browser.until("live", lambda: browser.js("return document.body.dataset.connection") == "live", 10)
        browser.until("alarms", lambda: browser.all(row(101)))
        kept = browser.js("return [Object.values(sessionStorage), Object.values(localStorage), location.href]")
        assert "secret-1" in kept[0] and "secret-1" not in str(kept[1:]), kept
        browser.click(browser.one("#sign-out"))
        browser.until("asked again", lambda: browser.js(DIALOG, "token"))
        browser.collect()
        assert not any("secret" in own for own in browser.requests), "the token is in an address"
    finally:
        mock.token = None


def one_bad_alarm_hides_no_other(browser, mock):
    fresh(browser, mock)
    mock.put_alarm({"id": "bad", "machine": "GT-02", "state": "active_unacknowledged", "severity": 999,
                    "fault": None, "source": None, "onset_interval_ms": 7, "hypotheses": 3})
    mock.put_alarm(plant.alarm(600, "GT-02"))
    browser.until("the next alarm", lambda: browser.all(row(600)) and browser.all(row(101)), 2)
    browser.until("both are counted", lambda: browser.text("#summary").startswith("5 open, 4 not"), 2)
    for own in browser.all(row(600, ".more")):
        browser.click(own)


CHECKS = [
    one_bad_alarm_hides_no_other, strings_stay_text, acknowledged_by_clicks, shelved_and_unshelved_by_clicks, all_by_keys_alone,
    new_alarm_is_heard, focus_outlives_updates, left_out_updates_are_told, history_is_read,
    no_sample_is_lost_while_a_trend_is_read, faults_are_tried, roles_see_what_they_may_use,
]
# These make the browser log that calls failed.
LOUD = [
    nothing_typed_is_lost, failed_readings_are_told, lost_connection_is_shown,
    silence_is_a_lost_connection, token_is_asked_for,
]
