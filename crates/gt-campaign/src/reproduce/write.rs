//! The folder of a reproduction: page, tables, figures, logs.

use std::fs;
use std::path::Path;

use gt_log::{
    LoggedModel, ModelFile, RunMetadata, write_atomically, write_json, write_run, write_verdicts,
};

use super::Reproduction;
use super::detection;
use super::records::{HEALTHY_RECORDS, Record};
use crate::error::CampaignError;
use crate::parallel;
use crate::progress::{Progress, report_or_stop};

impl Reproduction {
    /// Writes `index.html`, `tables.json`, `figures/*.svg`, `figures/*.csv`, `tables/*.csv`,
    /// `logs/*.mcap` and
    /// `models/*.json` below `folder`, which is made where it is missing. Files appear under
    /// their names only when they are whole.
    ///
    /// # Errors
    /// [`CampaignError`] names the file or folder; [`CampaignError::Stopped`] when progress says so
    /// before the first.
    pub fn write(&self, folder: &Path, progress: &dyn Progress) -> Result<(), CampaignError> {
        let make = |name: &str| {
            let path = folder.join(name);
            match fs::create_dir_all(&path) {
                Ok(()) => Ok(path),
                Err(source) => Err(CampaignError::Folder { path, source }),
            }
        };
        let (figures, logs, models) = (make("figures")?, make("logs")?, make("models")?);
        let what = "writing logs";
        report_or_stop(progress, what, 0, 1)?;
        let records: Vec<&Record> = self
            .records
            .iter()
            .flat_map(|records| {
                let groups = [
                    &records.identification,
                    &records.healthy,
                    &records.faults,
                    &records.signature,
                    &records.load_reduction,
                ];
                groups.into_iter().flatten()
            })
            .collect();
        parallel::map(&records, |record| {
            let path = logs.join(format!("{}.mcap", record.plan.name));
            write_run(&path, &record.run, &metadata(record)?).map_err(CampaignError::from)
        })?;
        let models_of_bank = self.logged_models()?;
        let paper = &self.records[0];
        let judged = paper.faults.iter().zip(&self.fault_runs);
        let judged = judged.chain(
            paper
                .healthy
                .get(HEALTHY_RECORDS)
                .map(|record| (record, &self.healthy_run)),
        );
        parallel::map(&judged.collect::<Vec<_>>(), |(record, run)| {
            let path = logs.join(format!("{}_verdicts.mcap", record.plan.name));
            let data = record.select(&detection::tags())?;
            let metadata = RunMetadata {
                models: models_of_bank.clone(),
                ..metadata(record)?
            };
            write_verdicts(&path, &self.bank, &data, run, &metadata).map_err(CampaignError::from)
        })?;
        for (identified, logged) in self.models.iter().zip(&models_of_bank) {
            let path = models.join(format!("{}.json", identified.monitored.tag));
            write_json(&path, &logged.file)?;
        }
        write_json(&models.join("bank.json"), &self.bank)?;
        for figure in &self.figures {
            figure.write(&figures)?;
        }
        let tables = make("tables")?;
        for (map_set, effects) in &self.tables.fault_effects {
            let path = tables.join(format!("fault_effects_{map_set}.csv"));
            write_atomically(&path, effects.csv().as_bytes())?;
        }
        let steady = self.tables.cogeneration.steady_csv();
        write_atomically(&tables.join("cogeneration_steady.csv"), steady.as_bytes())?;
        write_json(&folder.join("tables.json"), &self.tables)?;
        write_atomically(&folder.join("index.html"), self.page().as_bytes())?;
        progress.report(what, 1, 1);
        Ok(())
    }
}

impl Reproduction {
    /// The models of the bank, with their fits on the record of identification.
    fn logged_models(&self) -> Result<Vec<LoggedModel>, CampaignError> {
        let models = self.models.iter().map(|identified| {
            let fits = &identified.validations[0].outputs;
            Ok(LoggedModel {
                file: ModelFile::arx(identified.model.clone(), None)?,
                fit_prediction_percent: fits.iter().map(|own| own.fit_prediction_percent).collect(),
                fit_simulation_percent: fits.iter().map(|own| own.fit_simulation_percent).collect(),
            })
        });
        models.collect()
    }
}

fn metadata(record: &Record) -> Result<RunMetadata, CampaignError> {
    Ok(RunMetadata {
        seed: Some(record.plan.scenario.seed),
        run_index: Some(record.plan.scenario.run_index),
        config_toml: toml::to_string(&record.plan.scenario)?,
        ..RunMetadata::default()
    })
}
