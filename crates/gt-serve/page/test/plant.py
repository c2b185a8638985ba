"""A scripted plant for the tests of the page: every value is a function of time, nothing is random."""

import math
import time

DAY_MS = 86_400_000
HOSTILE = "<img src=x onerror=alert(1)>"

INPUTS = [
    ("a_v", "deg", 41.2), ("M_f", "kg/s", 0.2481), ("w_ref", "rad/s", 1047.2),
    ("p_a", "Pa", 101_325.0), ("T_a", "K", 288.15), ("LHV", "J/kg", 4.98e7),
]
OUTPUTS = [
    ("p2", "Pa", 1.3872e6), ("p3", "Pa", 1.3311e6), ("p4", "Pa", 1.0842e5), ("m3", "kg/s", 17.62),
    ("m6", "kg/s", 17.87), ("t2", "K", 671.4), ("t3", "K", 1368.2), ("t4", "K", 798.1),
    ("P_c", "W", 6.931e6), ("P_t", "W", 1.1284e7), ("N_t", "rpm", 10_000.0), ("q_t", "N m", 10_775.0),
]
FAULTS = ["compressor_fouling", "thermocouple_drift", "turbine_damage", "fuel_actuator_lag"]
LIMITS = [5.12, 4.87, 5.03, 4.66, 6.31]
SHA = "9f2c4e0b7a815d36c1e4f0a2937b68d5e0c9a1f4b2783d6e5f10a9c8b7d6e5f4"


def now_ms():
    """The wall clock in whole milliseconds."""
    return int(time.time() * 1000)


def ripple(seed, ms):
    """A slow wave with quick noise, about 1 at most; the same for the same time."""
    noise = math.sin((ms // 80) * 12.9898 + seed * 78.233) * 43758.5453
    return 0.45 * math.sin(ms / 97_000 + seed) + 1.1 * (noise - math.floor(noise) - 0.5)


class Machine:
    """A machine whose statistics grow from an onset."""

    def __init__(self, name, state, **more):
        self.name, self.state = name, state
        self.reason = more.get("reason")
        self.onset_ms = more.get("onset_ms")
        self.leading = more.get("leading", 1)
        self.stopped_ms = more.get("stopped_ms")
        self.detector = more.get("detector", True)
        self.bad = more.get("bad", {})
        self.born_ms = now_ms() - 9 * 3_600_000
        self.all_rows = self.make_rows()
        base = {tag: base for tag, _, base in INPUTS + OUTPUTS}
        self.bases = [base.get(tag, 1.0) for _, tag, _, _ in self.all_rows]

    def rows(self):
        """The series in the order of the trend: kind, tag, unit, limit."""
        return self.all_rows

    def make_rows(self):
        rows = [("statistic", name, "", limit) for name, limit in zip([*FAULTS, "any direction"], LIMITS)]
        rows += [("residual", tag, unit, 0.004 * abs(base)) for tag, unit, base in OUTPUTS]
        rows += [("output", tag, unit, None) for tag, unit, _ in OUTPUTS]
        return rows + [("input", tag, unit, None) for tag, unit, _ in INPUTS]

    def age_s(self, ms):
        return 0.0 if self.onset_ms is None else max(0.0, (ms - self.onset_ms) / 1000)

    def value(self, row, ms):
        """The value of a series at a time; None where the plant gave none."""
        if self.stopped_ms is not None and ms > self.stopped_ms:
            return None
        kind, tag, _, _ = self.all_rows[row]
        base = self.bases[row]
        if kind == "statistic":
            grown = self.age_s(ms) / 60
            own = grown**1.6 * (1.0 if row in (self.leading, 4) else 0.16)
            return max(0.02, 1.1 + 0.8 * ripple(row, ms) + own)
        if kind == "input":
            return base * (1 + 0.004 * ripple(row, ms)) if tag not in ("w_ref", "LHV") else base
        drift = 0.0008 * base * self.age_s(ms) / 60 if tag == "t3" else 0.0
        if kind == "residual":
            return 0.0012 * base * ripple(row, ms) + drift
        if self.bad.get(tag) == "bad":
            return None
        return base * (1 + 0.0015 * ripple(row, ms)) + drift

    def last_ms(self):
        if self.state == "no_data":
            return None
        return self.stopped_ms if self.stopped_ms is not None else now_ms() - 60

    def message(self, open_alarms):
        """The machine as the API tells it."""
        at = self.last_ms()
        rows = self.rows()
        value = (lambda row: None) if at is None else (lambda row: self.value(row, at))
        statistics = [
            {"name": tag, "value": value(row), "limit": limit}
            for row, (kind, tag, _, limit) in enumerate(rows) if kind == "statistic"
        ]
        ratios = [own["value"] / own["limit"] for own in statistics if own["value"] is not None]

        def tags(wanted):
            return [
                {"tag": tag, "unit": unit, "quality": self.bad.get(tag, "good"), "value": value(row)}
                for row, (kind, tag, unit, _) in enumerate(rows) if kind == wanted
            ]

        return {
            "name": self.name, "state": self.state, "reason": self.reason,
            "detector": {"name": "isolator-gt01", "kind": "isolator", "sha256": SHA} if self.detector else None,
            "last_time_ms": at, "inputs": tags("input"), "outputs": tags("output"),
            "statistics": statistics, "worst_ratio": max(ratios, default=None),
            "open_alarms": open_alarms,
            "samples": 0 if at is None else (at - self.born_ms) // 80, "missing_samples": 0 if at is None else 37,
        }

    def trend(self, seconds, points):
        """The trend as the API tells it: two samples a bucket stand for all."""
        end = self.last_ms()
        bucket = max(80, seconds * 1000 // points)
        rows = self.rows()
        first = 0 if end is None else (end - seconds * 1000) // bucket * bucket + bucket
        times = [] if end is None else list(range(first, end + 1, bucket))
        gap = range(first + bucket * points // 4, first + bucket * points // 4 + 12 * bucket)

        def ends(row, time_ms):
            if time_ms in gap:
                return None
            found = [self.value(row, time_ms + part * bucket // 2) for part in range(2)]
            found = [value for value in found if value is not None]
            return (min(found), max(found)) if found else None

        series = []
        for row, (kind, tag, unit, limit) in enumerate(rows):
            pairs = [ends(row, time_ms) for time_ms in times]
            series.append({
                "kind": kind, "tag": tag, "unit": unit, "limit": limit,
                "min": [pair and pair[0] for pair in pairs], "max": [pair and pair[1] for pair in pairs],
            })
        return {"machine": self.name, "bucket_ms": bucket, "times_ms": times, "series": series}


def alarm(number, machine, **more):
    """An alarm as the API tells it."""
    raised = more.pop("raised_ms", now_ms())
    own = {
        "id": str(number), "machine": machine, "source": "any direction", "fault": None,
        "finding": "undecided", "state": "active_unacknowledged", "shelved": None, "severity": 500,
        "raised_ms": raised, "named_ms": None, "ended_ms": None, "onset_ms": None,
        "onset_interval_ms": None, "magnitude": None, "magnitude_interval": None, "unit": None,
        "probability": None, "statistic": 6.94, "threshold": 6.31, "hypotheses": [],
        "none_of_these": None, "acknowledged": None, "detector": "isolator-gt01",
    }
    return own | more


def named(fault, onset_ms, magnitude, unit, probability, spread=0.2):
    """The keys of an alarm whose fault is known."""
    rest = 1 - probability
    shares = {name: rest * share for name, share in zip(FAULTS, (0.5, 0.2, 0.15, 0.1))}
    shares[fault] = probability
    units = {name: "s" if name == "fuel_actuator_lag" else "%" for name in FAULTS}

    def hypothesis(name):
        size = magnitude if name == fault else 0.7 * magnitude
        return {
            "fault": name, "probability": shares[name], "magnitude": size,
            "magnitude_interval": [size * (1 - spread), size * (1 + spread)], "unit": units[name],
            "onset_ms": onset_ms if name == fault else onset_ms + 20_000,
        }

    return {
        "fault": fault, "finding": "named", "source": fault, "onset_ms": onset_ms,
        "onset_interval_ms": [onset_ms - 28_000, onset_ms + 17_000], "magnitude": magnitude,
        "magnitude_interval": [magnitude * (1 - spread), magnitude * (1 + spread)], "unit": unit,
        "probability": probability, "hypotheses": [hypothesis(name) for name in FAULTS],
        "none_of_these": 0.05 * rest,
    }


def machines():
    """The plant's machines by name."""
    at = now_ms()
    all_of_them = [
        Machine("GT-01", "alarm", onset_ms=at - 330_000, bad={"t4": "uncertain", "m6": "bad"}),
        Machine("GT-02", "healthy"),
        Machine("GT-03 cogeneration", "settling", reason="settling after a gap of 12.4 s: 31 s to go"),
        Machine("GT-04", "stale", reason="no sample for 2 min", stopped_ms=at - 130_000),
        Machine("GT-05", "failed", reason="bank.json: 31 outputs expected, 28 found", stopped_ms=at - 4_000_000),
        Machine("GT-06 " + HOSTILE, "no_data", reason="waiting for " + HOSTILE, detector=False),
    ]
    return {machine.name: machine for machine in all_of_them}


def alarms():
    """The alarms to begin with, by id: two open, one shelved, some of the past."""
    at = now_ms()
    seen = {"by": "M. Keller", "at_ms": at - 3_100_000, "comment": "wash planned for tonight"}
    own = [
        alarm(101, "GT-01", severity=810, raised_ms=at - 150_000, named_ms=at - 138_000, statistic=9.83,
              threshold=4.87, **named("thermocouple_drift", at - 330_000, 1.84, "%", 0.974)),
        alarm(102, "GT-02", severity=520, raised_ms=at - 3_400_000, named_ms=at - 3_300_000,
              state="active_acknowledged", acknowledged=seen, statistic=5.9, threshold=5.12,
              **named("compressor_fouling", at - 6_400_000, 2.31, "%", 0.86, 0.3)),
        alarm(103, "GT-04", severity=240, raised_ms=at - 1_000_000, state="returned_unacknowledged",
              ended_ms=at - 700_000),
        alarm(104, "GT-05", severity=300, raised_ms=at - 5_000_000, state="active_unacknowledged",
              finding="none_of_these", none_of_these=0.91, probability=0.91,
              shelved={"until_ms": at + 3_600_000, "reason": "sensor under repair " + HOSTILE, "by": "A. Rossi"}),
        alarm(90, "GT-01", severity=700, raised_ms=at - DAY_MS, ended_ms=at - DAY_MS + 900_000,
              state="normal", acknowledged={**seen, "comment": HOSTILE}, named_ms=at - DAY_MS + 9000,
              **named("turbine_damage", at - DAY_MS - 60_000, 0.9, "%", 0.9995)),
        alarm(91, "GT-02", severity=400, raised_ms=at - 3 * DAY_MS, ended_ms=at - 3 * DAY_MS + 60_000,
              state="normal", acknowledged={**seen, "comment": ""}),
    ]
    return {each["id"]: each for each in own}
