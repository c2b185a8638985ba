"""Checks of the page's modules on their own, in the browser, with exact answers."""

import json

FORMATS = [
    ("number(0)", "0.000"), ("number(1368.24)", "1368"), ("number(-0.0123456)", "−0.01235"),
    ("number(1234567)", "1.23e+6"), ("number(null)", "–"), ("number(NaN)", "–"),
    ("quantity(1387200, 'Pa')", "1.39 MPa"), ("quantity(434, 'Pa')", "434 Pa"),
    ("quantity(1368.2, 'K', 5)", "1368.2 K"), ("quantity(null, 'K')", "–"), ("quantity(2, null)", "2.00"),
    ("interval([-1500, 2500], 'W')", "−1.50 to 2.50 kW"), ("interval([1, null], '%')", None),
    ("interval(null, '%')", None),
    ("percent(0.974)", "97 %"), ("percent(0.9999)", "> 99.9 %"), ("percent(1)", "100.0 %"),
    ("percent(0.0004)", "< 0.1 %"), ("percent(0.013)", "1.3 %"), ("percent(null)", "–"),
    ("duration(400)", "< 1 s"), ("duration(59999)", "59 s"), ("duration(200000)", "3 min 20 s"),
    ("duration(7500000)", "2 h 5 min"), ("duration(90000000)", "1 d 1 h"), ("duration(-5)", "< 1 s"),
    ("roughDuration(200000)", "3 min"), ("roughDuration(400)", "< 1 s"),
    ("count(1234567)", "1\u202f234\u202f567"),
    ("plainName('compressor_fouling and turbine_damage')", "Compressor fouling and turbine damage"),
    ("plainName('T3 drift')", "T3 drift"), ("plainName('')", ""),
    ("headline({ fault: null, finding: 'none_of_these' })", "None of the known faults"),
    ("priority(1000) + priority(666) + priority(1)", "highmediumlow"),
    ("zone(1750000000000)", "CEST"), ("zone(1795751833449)", "CET"),
    ("fullTime(1750000000000)", "15 Jun 2025, 17:06:40 CEST"), ("fullTime(1e300)", "–"), ("clock(null)", "–"),
]

STREAM = (
    ": alive\r\n\r\nevent: alarm\r\ndata: {\"id\": \"é\"}\r\n\r\nevent: none\n\n"
    "data: 1\n\nevent: sample\ndata: [1,\ndata: 2]\n\nevent: spoilt\ndata: {\n\nevent: last\ndata:3\n\nevent: half\ndata: 4\n"
)
EVENTS = [["alarm", {"id": "é"}], ["message", 1], ["sample", [1, 2]], ["last", 3]]

TREND = """
    const answer = { machine: 'm', bucket_ms: 1000, times_ms: [1000, 2000, 3000], series: [
      { kind: 'output', tag: 'a', unit: null, limit: null, min: [1, null, 3], max: [2, null, 3] },
      { kind: 'output', tag: 'b', unit: 'K', limit: null, min: [0, 0, 0], max: [0, 0, 0] } ] };
    const trend = new Trend(answer, 100_000);
    const told = [
      trend.add({ machine: 'm', time_ms: 3400, series: [[2, 5], null] }, false),
      trend.add({ machine: 'm', time_ms: 2100, series: [[-9, 9], [-9, 9]] }, false),
      trend.add({ machine: 'm', time_ms: 6999, series: [[7, 8], null] }, false),
      trend.add({ machine: 'm', time_ms: 7000, series: [[1, 1]] }, false),
    ];
    const [a, b] = trend.series;
    const text = (values) => values.map(String).join(' ');
    const before = [told.join(' '), text(trend.times), text(a.min), text(a.max), text(b.min),
      trend.gap_ms, trend.place(0), trend.place(2999), trend.place(1e9), trend.last(b).time_ms];
    for (let at = 0; at < 1000; at++) trend.add({ machine: 'm', time_ms: 7000 + 1000 * at, series: [[at, at], [at, at]] }, false);
    return [...before, trend.times.length <= 120 && trend.times.length >= 100,
      trend.times.length === a.min.length && a.min.length === b.max.length, a.max.at(-1)];
"""
TREND_TOLD = [
    "true true true false", "1000 2000 3000 6000", "1 NaN 2 7", "2 NaN 5 8", "0 0 0 NaN",
    2500, 0, 1, 3, 3000, True, True, 999,
]
TICKS = [("ticks(0, 10, 4)", [0, 2.5, 5, 7.5, 10]), ("ticks(-1, 1, 4)", [-1, -0.5, 0, 0.5, 1]),
         ("decades(0.8, 30, 5)", [1, 2, 5, 10, 20]), ("decades(0.001, 10, 5)", [0.001, 0.01, 0.1, 1, 10]),
         ("ticks(1, 1, 4)", []), ("ticks(0, Infinity, 4)", [])]


def evaluate(browser, url, module, code):
    """What an expression or function body over a module's names gives."""
    found = browser.driver.execute_async_script(
        "const done = arguments[2];"
        "import(arguments[0] + arguments[1]).then((own) => { globalThis.own = own; done(null); }, (error) => done(String(error)))",
        url, module,
    )
    assert found is None, found
    body = code if "return" in code else f"return {code}"
    names = browser.js("return Object.keys(globalThis.own)")
    found = browser.js(f"const {{ {', '.join(names)} }} = globalThis.own; {body}")
    # The space before a unit does not break.
    return found.replace("\u00a0", " ") if isinstance(found, str) else found


def numbers_times_and_names_read_so(browser, url, **_):
    for code, expected in FORMATS:
        found = evaluate(browser, url, "format.js", code)
        assert found == expected, f"{code}: expected {expected!r}, found {found!r}"
    for code, expected in TICKS:
        found = evaluate(browser, url, "chart.js", code)
        assert found == expected, f"{code}: expected {expected!r}, found {found!r}"
    return f"{len(FORMATS) + len(TICKS)} cases"


def streams_come_in_any_pieces(browser, url, **_):
    code = (
        "return (() => { const found = []; for (const size of [1, 2, 3, 7, 1000]) { const heard = [];"
        " const take = eventParser((name, data) => heard.push([name, data])); const text = %s;"
        " for (let at = 0; at < text.length; at += size) take(text.slice(at, at + size)); found.push(heard); }"
        " return found; })()"
    )
    found = evaluate(browser, url, "api.js", code % json.dumps(STREAM))
    assert found == [EVENTS] * 5, found


def samples_join_the_trend(browser, url, **_):
    found = evaluate(browser, url, "trend.js", TREND)
    assert found == TREND_TOLD, f"expected {TREND_TOLD}, found {found}"


CHECKS = [numbers_times_and_names_read_so, streams_come_in_any_pieces, samples_join_the_trend]
