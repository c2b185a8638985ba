//! From a record to a model: the order, the method, what is said about the outcome.

use gt_ident::eiv::{
    ChannelNoise, Eiv, EivIdentification, EivLags, EivMethod, EivRemark, eiv_order_table,
};
use gt_ident::frisch::{Criterion, CriterionKind, Frisch};
use gt_ident::{IdentError, OrderChoice};

use super::system::{m1, s1};

#[test]
fn a_given_order_is_the_fit_of_its_lags() {
    let data = m1(20.0).record(1500, 31, 0);
    let lags = |nk: &[usize]| EivLags::new(2, nk.to_vec()).unwrap();
    let given = || EivIdentification::new(OrderChoice::Given(2));
    let fit = |wish: EivIdentification| wish.identify(&data).unwrap();
    // One smallest lag stands for all inputs.
    for (wish, nk) in [
        (given(), [1, 1]),
        (given().nk(vec![0]), [0, 0]),
        (given().nk(vec![1, 0]), [1, 0]),
    ] {
        let found = fit(wish);
        let eiv = Eiv::new(vec![lags(&nk)]).fit(&data).unwrap();
        assert_eq!(found.model, eiv.model(&data).unwrap());
        assert_eq!(found.orders, None);
    }
    let options = EivMethod::Likelihood {
        autoregression_order: Some(20),
        frequencies: Some(100),
        pole_prior: 10.0,
    };
    let eiv = Eiv::new(vec![lags(&[1, 1])]);
    let eiv = eiv.autoregression_order(20).frequencies(100);
    let eiv = eiv.pole_prior(10.0).fit(&data);
    assert_eq!(
        fit(given().method(options)).model,
        eiv.unwrap().model(&data).unwrap()
    );
    for (kind, criterion) in [
        (CriterionKind::Shift, Criterion::ShiftRelation),
        (
            CriterionKind::Covariance,
            Criterion::CovarianceMatch { lags: 7 },
        ),
        (CriterionKind::YuleWalker, Criterion::default()),
    ] {
        let scheme = Frisch::new(lags(&[1, 1])).criterion(criterion);
        let expected = scheme.fit_shared(&data).unwrap().model(&data).unwrap();
        let found = fit(given().method(EivMethod::Frisch(kind)));
        assert_eq!(found.model, expected, "{kind:?}");
    }
}

#[test]
fn an_automatic_order_looks_as_far_as_the_record_bears() {
    let automatic = EivIdentification::new(OrderChoice::Automatic);
    let data = s1(20.0).record(2000, 21, 0);
    let found = automatic.identify(&data).unwrap();
    let table = found.orders.unwrap();
    assert_eq!(table, eiv_order_table(&data, 1..=6, &[1]).unwrap());
    assert_eq!(found.model.relation().max_lag(), 2, "the true order");
    let short = data.rows(0..36).unwrap();
    let found = automatic.identify(&short).unwrap();
    let highest = found.orders.unwrap().rows.last().unwrap().order;
    assert!(matches!(
        eiv_order_table(&short, 1..=highest + 1, &[1]),
        Err(IdentError::EivTooFewSamples { found: 36, .. })
    ));
    assert_eq!(
        found.remarks[0],
        EivRemark::NoHigherOrder {
            samples: 36,
            highest
        }
    );
    // The smallest lag is the first order there is.
    let late = automatic.clone().nk(vec![3]).identify(&data).unwrap();
    assert_eq!(late.orders.unwrap().rows[0].order, 3);
}

#[test]
fn what_cannot_be_identified_is_refused() {
    let data = s1(20.0).record(300, 1, 0);
    let refused = |order, nk: &[usize]| {
        let wish = EivIdentification::new(order).nk(nk.to_vec());
        wish.identify(&data).unwrap_err()
    };
    assert_eq!(refused(OrderChoice::Given(0), &[0]), IdentError::EivOrder);
    let late = IdentError::EivLag {
        input: 0,
        order: 2,
        found: 3,
    };
    assert_eq!(refused(OrderChoice::Given(2), &[3]), late);
    assert_eq!(refused(OrderChoice::Search(2..=4), &[3]), late);
    let error = refused(OrderChoice::Given(2), &[1, 1]);
    assert!(matches!(error, IdentError::Dimension(_)), "{error}");
}

#[test]
fn remarks_say_what_a_user_should_know() {
    let noise = |standard_error, at_limit| EivRemark::NoiseNotTold {
        channel: "u".to_owned(),
        noise: ChannelNoise {
            variance: 0.25,
            standard_error,
            at_limit,
        },
    };
    for (remark, text) in [
        (
            EivRemark::NoHigherOrder {
                samples: 60,
                highest: 4,
            },
            "60 rows bear no order above 4: the search looked no further",
        ),
        (
            EivRemark::ShortRecord { samples: 60 },
            "60 rows are few for this model: the standard errors promise too much",
        ),
        (
            EivRemark::NotConverged,
            "the search for the likelihood's maximum did not end",
        ),
        (
            noise(Some(0.5), false),
            "the record does not tell the noise of `u`: variance 2.500e-1, standard error 5.000e-1",
        ),
        (
            noise(Some(0.5), true),
            "the record does not tell the noise of `u`: variance 2.500e-1, it stands at a limit of \
             the search",
        ),
        (
            noise(None, false),
            "the record does not tell the noise of `u`: variance 2.500e-1, its standard error is without bound",
        ),
    ] {
        assert_eq!(remark.to_string(), text);
    }
}
