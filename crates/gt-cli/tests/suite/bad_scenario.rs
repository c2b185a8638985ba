//! Scenarios that make no sense.

use crate::place::Place;
use crate::scenario::simulate;

/// Refuses each scenario with its text, after the name of the file.
fn refused(cases: &[(&str, &str)]) {
    let place = Place::new();
    let args = simulate(&["--scenario", "s.toml"]);
    for (scenario, text) in cases {
        place.write("s.toml", scenario);
        place.refused_exactly(&args, &format!("s.toml: {text}"));
    }
}

#[test]
fn impossible_values_name_their_file() {
    refused(&[
        (
            "[[faults]]\nsensor = \"P_e\"\nmode = \"bias\"\nstep = { size = 1.0 }\n",
            "sensor of a fault: expected in the variant prototype a channel of its records, found \
             P_e",
        ),
        (
            "[[faults]]\nactuator = \"IGV\"\nmode = \"stuck\"\n",
            "actuator of a fault: expected in the variant prototype a channel of its records, \
             found IGV",
        ),
        (
            "duration_s = -5.0\n",
            "duration: expected between 0.08 and 160000 s, found -5",
        ),
        (
            "substeps = 23\n",
            "substeps: expected 24 to 10000 a sample (a step of at most 0.003400 s), found 23",
        ),
        (
            "profile = \"load_reduction_igv\"\n",
            "profile: expected one of steady, gentle, standard, lively, wide, found \
             `load_reduction_igv`",
        ),
        (
            "[profile]\nfuel_schedule = [[0.0, 0.9]]\n",
            "fuel_schedule: expected in the variant prototype none, as the governor sets the \
             fuel, found 1 points",
        ),
        (
            "[boundary.temperature_k]\noffset = 50.0\n",
            "boundary.temperature_k: expected between 233 and 333 K throughout, 5 standard \
             deviations included, found 338.16",
        ),
        (
            "[boundary.pressure_pa]\noffset = 1e4\n",
            "boundary.pressure_pa: expected between 80000 and 110000 Pa throughout, 5 standard \
             deviations included, found 111325",
        ),
        (
            "[boundary.heating_value_fraction]\noffset = nan\n",
            "boundary.heating_value_fraction: expected a finite offset, found NaN",
        ),
        (
            "[disturbance]\ntorque_n_m = { deviation = -1.0, time_constant_s = 1.0 }\n",
            "disturbance.torque_n_m: expected a deviation between 0 and 500 N m, found -1",
        ),
        (
            "[profile]\nvalve_amplitude_deg = 90.0\n",
            "valve_amplitude_deg: expected between 0 and 20, found 90",
        ),
        (
            "[noise.channels.t3]\ndeviation = -1.0\n",
            "noise of t3, deviation: expected a number from 0 to 1e12, found -1",
        ),
        (
            "[noise.channels.P_e]\ndeviation = 1.0\n",
            "channel of noise: expected in the variant prototype a channel of its records, found \
             P_e",
        ),
    ]);
}

#[test]
fn keys_and_names_that_are_none_name_their_line() {
    refused(&[
        (
            "variant = \"jet\"\n",
            "TOML parse error at line 1, column 11|unknown variant `jet`, expected `prototype` or \
             `cogeneration`",
        ),
        (
            "noise = \"loud\"\n",
            "TOML parse error at line 1, column 9|noise: expected one of none, low, table8, \
             table8_variance, tables4_5, found `loud`",
        ),
        (
            "seed = 1\nduration = 60.0\n",
            "TOML parse error at line 2, column 1|unknown field `duration`, expected one of \
             `variant`, `map_set`, ",
        ),
        (
            "seed = 1\n\n[boundary.temperature_k]\nofset = 1.0\n",
            "TOML parse error at line 4, column 1|unknown field `ofset`, expected one of \
             `offset`, `rate_per_h`, ",
        ),
        (
            "[profile]\nvalve_amplitude = 1.0\n",
            "TOML parse error at line 2, column 1|unknown field `valve_amplitude`, expected one \
             of `valve_amplitude_deg`, `valve_hold_s`, ",
        ),
        (
            "seed = 1\n\n[[faults]]\nsensor = \"t3\"\nmode = \"bias\"\nsize = 1.0\n",
            "TOML parse error at line 6, column 1|unknown field `size`, expected one of `case`, \
             `sensor`, ",
        ),
    ]);
}

#[test]
fn what_an_option_breaks_names_the_option() {
    let place = Place::new();
    place.write("s.toml", "map_set = \"axial\"\n");
    let file = simulate(&["--scenario", "s.toml"]);
    for (tail, text) in [
        (
            ["--seconds", "-5"],
            "--seconds: expected between 0.08 and 160000 s, found -5",
        ),
        (
            ["--substeps", "23"],
            "--substeps: expected 24 to 10000 a sample (a step of at most 0.003455 s), found 23",
        ),
        (
            ["--profile", "load_reduction_fuel"],
            "--profile: expected one of steady, gentle, standard, lively, wide, found \
             `load_reduction_fuel`",
        ),
        (
            ["--variant", "jet"],
            "--variant: expected one of prototype, cogeneration, found `jet`",
        ),
        (
            ["--map-set", "flat"],
            "--map-set: expected one of paper, axial, found `flat`",
        ),
        (
            ["--noise", "loud"],
            "--noise: expected one of none, low, table8, table8_variance, tables4_5, found `loud`",
        ),
    ] {
        place.refused_exactly(&[&file[..], &tail].concat(), text);
    }
}

#[test]
fn what_a_fault_file_breaks_names_that_file() {
    let place = Place::new();
    place.write(
        "faults.toml",
        "[[fault]]\nactuator = \"IGV\"\nmode = \"stuck\"\n",
    );
    place.write("p.toml", "");
    let both = simulate(&["--scenario", "p.toml", "--faults", "faults.toml"]);
    place.refused_exactly(
        &both,
        "faults.toml: actuator of a fault: expected in the variant prototype a channel of its \
         records, found IGV",
    );
    place.write("p.toml", "[profile]\nvalve_amplitude_deg = 90.0\n");
    place.refused_exactly(
        &both,
        "p.toml: valve_amplitude_deg: expected between 0 and 20, found 90",
    );
    place.refused_exactly(
        &simulate(&["--scenario", "none.toml"]),
        "none.toml: No such file or directory (os error 2)",
    );
}
