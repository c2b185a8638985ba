//! debug
use gt_campaign::isolation::*;
use gtfdi::fdi::IsolationDetector;
use gtfdi::plant::*;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let level = NoiseLevel::try_from(std::env::args().nth(1).unwrap())?;
    let setting = Setting::new(MapSet::Paper, level, Ambient::Constant, 1)?;
    let prepared = Preparation {
        healthy_hours: 8,
        arl0_hours: 24.0,
    }
    .prepare(&setting)?;
    let sizes = if level == NoiseLevel::None {
        [0.06, 0.04, 0.1, 0.06]
    } else {
        [0.15, 0.1, 0.5, 0.5]
    };
    {
        let quiet = if std::env::args().nth(2).is_some() {
            setting.clone()
        } else {
            setting.without_noise()
        };
        let iso = &prepared.isolator;
        let dirs = iso.directions()?;
        for c in 0..3 {
            let f = Fault::growing(FaultCase::ALL[c], 130.0, sizes[c] * 60.0, Some(sizes[c]));
            for index in [50u64, 51] {
                let d = quiet.records(&[(index, vec![f.clone()]), (index, vec![])], 400.0)?;
                let res = |d: &gtfdi::core::Dataset| iso.generators()[0].residuals(d).unwrap();
                let dv = iso.whitening().response(&(res(&d[0]) - res(&d[1])))?;
                println!(
                    "direction {:.3?}",
                    dirs[c].as_ref().map(|d| d.as_slice().to_vec())
                );
                for t in [150.0, 170.0, 190.0, 220.0, 300.0, 390.0f64] {
                    let k = (t / 0.08) as usize;
                    let m = dv.columns(k - 60, 60).column_sum() / 60.0 / f.magnitude(t - 2.4);
                    println!("  {t}: {:.3?}", m.as_slice());
                }
            }
        }
    }
    if std::env::args().nth(2).is_some() {
        return Ok(());
    }
    for c in 0..4 {
        for index in 0..2u64 {
            let f = Fault::growing(FaultCase::ALL[c], 130.0, sizes[c] * 60.0, Some(sizes[c]));
            let d = setting
                .records(&[(30000 + index, vec![f])], 250.0)?
                .remove(0);
            let mut det = IsolationDetector::new(&prepared.isolator)?;
            let mut due = f64::INFINITY;
            println!("case {} size {}", c + 1, sizes[c]);
            for k in 0..d.len() {
                let (u, y) = (d.u().column(k), d.y().column(k));
                let v = det.step(d.time_s(k), u.as_slice(), y.as_slice())?;
                if v.new_alarm {
                    due = v.time_s;
                    println!("  alarm {} stats {:.1?}", v.time_s, v.statistics);
                }
                let t = v.time_s;
                if t >= due {
                    due = t + if due > 220.0 { 25.0 } else { 5.0 };
                    let s = std::time::Instant::now();
                    let g = det.diagnose();
                    println!(
                        "  {t:.1} {:?} p {:.4?} other {:.4} pair {:?} mag {:.3?} age {:.0?} in {} us",
                        g.finding,
                        g.hypotheses
                            .iter()
                            .map(|h| h.probability)
                            .collect::<Vec<_>>(),
                        g.none_of_these,
                        g.pair.map(|p| (p.faults, p.probability)),
                        g.hypotheses.iter().map(|h| h.magnitude).collect::<Vec<_>>(),
                        g.hypotheses.iter().map(|h| h.age).collect::<Vec<_>>(),
                        s.elapsed().as_micros()
                    );
                }
            }
        }
    }
    Ok(())
}
