"""Tables as plants export them, by the keywords of ``read``."""

import numpy as np
import pytest

import gtfdi

SHEET = (
    "Anlage 3\r\n\r\nZeit;10FT1;10TT1\r\n;kg/h;\u00b0C\r\n"
    + "".join(f"01.07.2026 10:00:{s:02};{36 * s},5;{s * s % 7},25\r\n" for s in range(20))
)
SHEET_OPTIONS = dict(encoding="windows-1252", header_line=3, time="Zeit")


def write(folder, name, text, encoding="utf-8"):
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def test_a_spreadsheet_is_read_as_it_is_saved(tmp_path):
    path = write(tmp_path, "sheet.csv", SHEET, "windows-1252")
    data = gtfdi.read(path, inputs="10FT1", outputs="10TT1", time_zone="Europe/Berlin",
                      decimal="comma", **SHEET_OPTIONS)
    assert data.sample_time_s == 1.0
    np.testing.assert_array_equal(data.u[:, 0], [36 * s + 0.5 for s in range(20)])
    np.testing.assert_array_equal(data.y[:, 0], [s * s % 7 + 0.25 for s in range(20)])
    assert (data.input_units, data.output_units) == (["kg/h"], ["\u00b0C"])


def test_tags_are_named_and_converted(tmp_path):
    path = write(tmp_path, "sheet.csv", SHEET, "windows-1252")
    tags = write(tmp_path, "tags.toml",
                 '[tags.10FT1]\nname = "fuel"\nto = "kg/s"\n[tags.10TT1]\nname = "t"\n')
    data = gtfdi.read(path, inputs="fuel", outputs="t", tags=tags, **SHEET_OPTIONS)
    assert (data.inputs, data.input_units) == (["fuel"], ["kg/s"])
    np.testing.assert_allclose(data.u[:, 0], [(36 * s + 0.5) / 3600 for s in range(20)], rtol=1e-15)


def test_missing_samples_break_a_record_or_are_refused(tmp_path):
    rows = [f"{t},{t % 3},{'stuck' if t == 4 else t * t % 5}\n" for t in range(12) if t not in (7, 8)]
    path = write(tmp_path, "gaps.csv", "time,u,y\n" + "".join(rows))
    options = dict(inputs="u", outputs="y")
    with pytest.raises(gtfdi.LogError, match="line 6, column `y`: .* found `stuck`"):
        gtfdi.read(path, **options)
    with pytest.warns(UserWarning):
        data = gtfdi.read(path, missing="break", bad_values="stuck", **options)
    # The gap in time is of samples that are missing too.
    assert len(data) == 12
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(data.y[:, 0])), [4, 7, 8])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(data.u[:, 0])), [7, 8])


def test_readings_at_their_own_times_are_resampled(tmp_path):
    rows = [f"u,{t},{t}\ny,{t + 0.5},{10 * t}\n" for t in range(10)]
    path = write(tmp_path, "long.csv", "tag,time,value\n" + "".join(rows))
    options = dict(inputs="u", outputs="y", layout="long")
    with pytest.raises(gtfdi.LogError, match="give resample_s with the sample time"):
        gtfdi.read(path, **options)
    with pytest.warns(UserWarning, match="resampled `u`: 5 averaged|averaged from 10"):
        data = gtfdi.read(path, resample_s=2.0, **options)
    assert data.sample_time_s == 2.0
    np.testing.assert_array_equal(data.u[:, 0], [0.5, 2.5, 4.5, 6.5, 8.5])
    np.testing.assert_array_equal(data.y[:, 0], [5.0, 25.0, 45.0, 65.0, 85.0])
    with pytest.warns(UserWarning, match="held"):
        data = gtfdi.read(path, resample_s=1.0, resample_method="hold", hold_at_most_s=1.0,
                          missing="break", **options)
    np.testing.assert_array_equal(data.y[1:, 0], [10.0 * (t - 1) for t in range(1, 10)])
    assert np.isnan(data.y[0, 0])


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        (dict(decimal="dot"), gtfdi.OptionError,
         "option decimal: expected point or comma, found \"dot\""),
        (dict(layout="tall"), gtfdi.OptionError,
         "option layout: expected wide or long, found \"tall\""),
        (dict(missing="skip"), gtfdi.OptionError,
         "option missing: expected refuse or break, found \"skip\""),
        (dict(resample_s=1.0, resample_method="median"), gtfdi.OptionError,
         "option resample_method: expected mean, hold or linear, found \"median\""),
        (dict(hold_at_most_s=1.0), gtfdi.OptionError,
         "option `hold_at_most_s`: expected with resample_s, found without"),
        (dict(resample_s=-1.0), gtfdi.LogError,
         "resample_s: expected a positive, finite number of seconds, found -1"),
        (dict(resample_s=1.0, resample_method="hold"), gtfdi.LogError,
         "hold_at_most_s: required with resample_method hold and linear, for example "
         "hold_at_most_s 60"),
        (dict(time_zone="Rome"), gtfdi.LogError,
         "time_zone: expected a name of the IANA database such as Europe/Rome, found `Rome`"),
        (dict(header_line=0), gtfdi.LogError,
         "header_line: expected a line from 1 on, found 0"),
        (dict(bad_values=["1"]), gtfdi.LogError,
         "bad_values: expected words, found the number `1`"),
    ],
)
def test_keywords_that_do_not_fit_are_refused(tmp_path, options, error, text):
    path = write(tmp_path, "a.csv", "u,y\n1,2\n3,4\n")
    with pytest.raises(error) as found:
        gtfdi.read(path, inputs="u", outputs="y", **options)
    assert str(found.value) == text
