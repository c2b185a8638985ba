use super::systems::Vector;
use gt_ident::eiv::EivLags;
use gt_ident::frisch::{Criterion, Frisch, WeightedMoments};
#[test]
fn probe_moments() {
    for (v, n) in [(Vector::s1(), 2000), (Vector::m1(), 2000)] {
        let mut truth = v.numbers("theta");
        truth.extend(v.numbers("sigma2"));
        let bound: Vec<f64> = v
            .numbers("crlb_std_semi_N500")
            .iter()
            .map(|b| b / (n as f64 / 500.0).sqrt())
            .collect();
        let mut sq = vec![0.0; truth.len()];
        let mut pred = vec![0.0; truth.len()];
        let mut stat = 0.0;
        let mut bad = 0;
        let mut failed = 0;
        let runs = 100;
        for run in 0..runs {
            let data = v.simulate(run, n);
            match WeightedMoments::new(v.lags()).fit(&data, 0) {
                Ok(f) => {
                    let mut est: Vec<f64> = f.row.theta().iter().copied().collect();
                    est.push(f.noise.output);
                    est.extend(f.noise.inputs.iter());
                    let mut e: Vec<f64> = f.coefficient_error.iter().copied().collect();
                    e.push(f.noise_error.output);
                    e.extend(f.noise_error.inputs.iter());
                    for k in 0..truth.len() {
                        sq[k] += (est[k] - truth[k]).powi(2) / runs as f64;
                        pred[k] += e[k] / runs as f64;
                    }
                    stat += f.statistic / runs as f64;
                    if run == 0 {
                        println!("dof {}", f.degrees_of_freedom)
                    }
                }
                Err(e) => {
                    failed += 1;
                    println!("{e}")
                }
            }
            bad += 0;
        }
        let r: Vec<f64> = sq.iter().zip(&bound).map(|(s, b)| s.sqrt() / b).collect();
        let p: Vec<f64> = sq.iter().zip(&pred).map(|(s, b)| s.sqrt() / b).collect();
        println!("rmse/crlb {r:.2?} rmse/pred {p:.2?} stat {stat:.2} failed {failed} {bad}");
    }
}
fn destill(name: &str) -> Option<gt_core::Dataset> {
    let text = std::fs::read_to_string(format!("/work/shared/data/{name}")).ok()?;
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|f| f.trim().parse().unwrap()).collect())
        .collect();
    let u = nalgebra::DMatrix::from_fn(5, rows.len(), |i, t| rows[t][i]);
    let y = nalgebra::DMatrix::from_fn(3, rows.len(), |i, t| rows[t][5 + i]);
    Some(super::systems::dataset(u, y))
}
#[test]
fn probe_destill() {
    let Some(d) = destill("destill_n10.csv") else {
        return;
    };
    let vy = [
        0.12207362928711112,
        0.012497669862024696,
        0.0004624663356488885,
    ];
    let vu = [
        1.4335623165611105e-07,
        4.009981526543903e-08,
        3.3683704740249506e-08,
        0.01625519360883469,
        0.0039021516325432096,
    ];
    for order in 3..=3 {
        for crit in [
            Criterion::ShiftRelation,
            Criterion::CovarianceMatch { lags: order + 1 },
            Criterion::HighOrderYuleWalker { lags: 5 },
        ] {
            for nk in [0, 1] {
                let f = Frisch::new(EivLags::new(order, vec![nk; 5]).unwrap()).criterion(crit);
                let start = std::time::Instant::now();
                for out in 0..3 {
                    match f.fit(&d, out) {
                        Ok(e) => {
                            let rel: Vec<f64> = e
                                .channels
                                .iter()
                                .map(|c| c.least_standard_error / c.variance)
                                .collect();
                            let ui: Vec<f64> =
                                e.noise.inputs.iter().zip(&vu).map(|(a, b)| a / b).collect();
                            println!(
                                "n {order} nk {nk} {crit:?} out {out} y {:.2} u {ui:.2?} rel {rel:.2?} ident {:?}",
                                e.noise.output / vy[out],
                                e.channels
                                    .iter()
                                    .map(|c| c.is_identifiable())
                                    .collect::<Vec<_>>()
                            );
                        }
                        Err(e) => println!("n {order} {crit:?} {e}"),
                    }
                }
                match f.fit_shared(&d) {
                    Ok(e) => {
                        let yi: Vec<f64> =
                            e.output_noise.iter().zip(&vy).map(|(a, b)| a / b).collect();
                        let ui: Vec<f64> =
                            e.input_noise.iter().zip(&vu).map(|(a, b)| a / b).collect();
                        println!(
                            "     shared y {yi:.2?} u {ui:.2?} ident {:?}",
                            e.channels
                                .iter()
                                .map(|c| c.is_identifiable())
                                .collect::<Vec<_>>()
                        );
                    }
                    Err(e) => println!("shared {e}"),
                }
                println!("   {:?}", start.elapsed());
            }
        }
    }
}
