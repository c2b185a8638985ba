//! The TOML files of users: campaigns, scenarios, described faults, tags, the service.

#![no_main]

use gt_campaign::FaultDescriptions;
use gt_campaign::campaign::Spec;
use gt_log::TagMap;
use gt_serve::ServeConfig;
use gtfdi::plant::Scenario;
use gtfdi::plant::maps::SpeedLineTable;
use gtfdi_fuzz::with_file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    with_file("file.toml", data, |path| {
        if let Ok(spec) = Spec::read(path) {
            let _ = spec.validate();
        }
        let _ = TagMap::read(path);
    });
    if let Ok(scenario) = toml::from_str::<Scenario>(text) {
        let _ = scenario.validate();
    }
    if let Ok(described) = toml::from_str::<FaultDescriptions>(text) {
        let _ = described.check();
    }
    let _ = toml::from_str::<SpeedLineTable>(text);
    if let Ok(config) = toml::from_str::<ServeConfig>(text) {
        let _ = config.check();
    }
});
