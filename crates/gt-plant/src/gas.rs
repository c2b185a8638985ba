//! Air and combustion products as ideal gases with temperature-dependent heat capacity.
//!
//! The polynomial of air is within half a percent of tables from 200 K to 1200 K and 1.6 % high at
//! 1500 K; above 1600 K it is of no use. The term for products is linear in temperature and
//! proportional to the mass fraction of burnt fuel, about that of a liquid fuel (CH2; products of
//! natural gas have a heat capacity about 1 % higher), and the gas constant is that of air. All
//! assumed: the paper asks for specific heats that depend on temperature and composition and prints
//! none.

use crate::real::Real;

/// Specific gas constant of air, J/(kg K); also used for products, whose fuel share is below 2 %.
pub const GAS_CONSTANT_J_KG_K: f64 = 287.05;

/// Coefficients of the heat capacity of air, J/(kg K) per power of K.
const AIR: [f64; 5] = [1057.5, -0.4489, 1.1407e-3, -7.9999e-7, 1.9327e-10];

/// Coefficients of the extra heat capacity of products per fuel mass fraction.
const PRODUCTS: [f64; 2] = [750.0, 1.16];

/// A mixture of air and burnt fuel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gas<R = f64> {
    /// Mass fraction of burnt fuel.
    fuel_fraction: R,
}

impl<R: Real> Gas<R> {
    /// Air with `fuel_air_ratio` kilograms of burnt fuel per kilogram of air.
    #[inline(always)]
    pub fn products(fuel_air_ratio: R) -> Self {
        Self {
            fuel_fraction: fuel_air_ratio / (fuel_air_ratio + 1.0),
        }
    }

    /// Heat capacity at constant pressure, J/(kg K).
    #[inline(always)]
    pub fn heat_capacity(&self, temperature_k: R) -> R {
        let extra = temperature_k * PRODUCTS[1] + PRODUCTS[0];
        self.fuel_fraction
            .mul_add(extra, air::heat_capacity(temperature_k))
    }

    /// Specific enthalpy, J/kg: the integral of the heat capacity from 0 K.
    #[inline(always)]
    pub fn enthalpy(&self, temperature_k: R) -> R {
        let extra = temperature_k * (temperature_k * (PRODUCTS[1] / 2.0) + PRODUCTS[0]);
        self.fuel_fraction
            .mul_add(extra, air::enthalpy(temperature_k))
    }

    /// Mean heat capacity between two temperatures, J/(kg K).
    #[inline(always)]
    pub fn mean_heat_capacity(&self, from_k: R, to_k: R) -> R {
        let extra = (from_k + to_k) * (PRODUCTS[1] / 2.0) + PRODUCTS[0];
        self.fuel_fraction
            .mul_add(extra, air::mean_heat_capacity(from_k, to_k))
    }

    /// Ratio of heat capacities, cp / (cp - R).
    #[inline(always)]
    pub fn heat_capacity_ratio(&self, temperature_k: R) -> R {
        ratio(self.heat_capacity(temperature_k))
    }

    /// The temperature at which the enthalpy is `enthalpy_j_kg`, by `steps` of Newton from
    /// `start_k`.
    ///
    /// An error of e kelvin becomes `cp' / (2 cp) e^2`, about `1e-4 e^2 / K`: three steps from
    /// 250 K off leave 2e-9 K.
    #[inline(always)]
    pub fn temperature_k(&self, enthalpy_j_kg: R, start_k: R, steps: usize) -> R {
        let mut t = start_k;
        for _ in 0..steps {
            t = t - (self.enthalpy(t) - enthalpy_j_kg) / self.heat_capacity(t);
        }
        t
    }
}

#[inline(always)]
fn ratio<R: Real>(cp: R) -> R {
    cp / (cp - GAS_CONSTANT_J_KG_K)
}

/// Pure air.
pub mod air {
    use super::{AIR, ratio};
    use crate::real::{Real, polynomial};

    /// Heat capacity at constant pressure, J/(kg K).
    #[inline(always)]
    pub fn heat_capacity<R: Real>(temperature_k: R) -> R {
        polynomial(temperature_k, AIR)
    }

    /// Specific enthalpy, J/kg: the integral of the heat capacity from 0 K.
    #[inline(always)]
    pub fn enthalpy<R: Real>(temperature_k: R) -> R {
        let [a0, a1, a2, a3, a4] = AIR;
        temperature_k * polynomial(temperature_k, [a0, a1 / 2.0, a2 / 3.0, a3 / 4.0, a4 / 5.0])
    }

    /// The part of the entropy that depends on temperature, J/(kg K): the integral of `cp / T`.
    #[inline(always)]
    pub fn entropy<R: Real>(temperature_k: R) -> R {
        let [a0, a1, a2, a3, a4] = AIR;
        let rest = polynomial(temperature_k, [a1, a2 / 2.0, a3 / 3.0, a4 / 4.0]);
        temperature_k.mul_add(rest, temperature_k.ln() * a0)
    }

    /// Mean heat capacity between two temperatures, J/(kg K).
    ///
    /// The difference quotient of the enthalpy, factored so that equal temperatures need no
    /// division by zero.
    #[inline(always)]
    pub fn mean_heat_capacity<R: Real>(from_k: R, to_k: R) -> R {
        let [a0, a1, a2, a3, a4] = AIR;
        let sum = from_k + to_k;
        let squares = from_k.mul_add(from_k, to_k * to_k);
        let product = from_k * to_k;
        let fourth = squares.mul_add(squares, product * (squares - product));
        let low = sum * (a1 / 2.0) + (squares + product) * (a2 / 3.0) + a0;
        low + (sum * squares) * (a3 / 4.0) + fourth * (a4 / 5.0)
    }

    /// Ratio of heat capacities, cp / (cp - R).
    #[inline(always)]
    pub fn heat_capacity_ratio<R: Real>(temperature_k: R) -> R {
        ratio(heat_capacity(temperature_k))
    }

    /// The temperature, K, after an isentropic change of pressure by the factor `pressure_ratio`,
    /// by four steps of Newton on the entropy from the constant ratio 1.39.
    #[inline(always)]
    pub fn isentropic_k<R: Real>(from_k: R, pressure_ratio: R) -> R {
        let log = pressure_ratio.ln();
        let wanted = entropy(from_k) + log * super::GAS_CONSTANT_J_KG_K;
        let mut t = from_k * (log * 0.28).exp();
        for _ in 0..4 {
            t = t - (entropy(t) - wanted) * t / heat_capacity(t);
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn published_air_near_room_temperature() {
        // 1004 to 1007 J/(kg K) at 300 K in any table of air.
        assert!((air::heat_capacity(300.0) - 1005.5).abs() < 2.0);
        assert!((air::heat_capacity_ratio(300.0) - 1.4).abs() < 0.002);
        // Gas tables: air compressed isentropically from 300 K by 10 reaches 574 K.
        assert!((air::isentropic_k(300.0, 10.0) - 574.0).abs() < 1.0);
    }

    #[test]
    fn products_without_fuel_are_air() {
        let gas = Gas::products(0.0);
        for t in [250.0, 600.0, 1400.0] {
            assert_eq!(gas.enthalpy(t).to_bits(), air::enthalpy(t).to_bits());
        }
    }

    proptest! {
        #[test]
        fn prop_enthalpy_is_the_integral(t in 250.0..1700.0f64, ratio in 0.0..0.05f64) {
            let gas = Gas::products(ratio);
            let slope = (gas.enthalpy(t + 0.5) - gas.enthalpy(t - 0.5)) / 1.0;
            // The midpoint rule errs by cp'' / 24 < 1e-3 J/(kg K).
            prop_assert!((slope - gas.heat_capacity(t)).abs() < 1e-3);
        }

        #[test]
        fn prop_mean_is_the_difference_quotient(a in 250.0..900.0f64, b in 901.0..1700.0f64) {
            let gas = Gas::products(0.02);
            let quotient = (gas.enthalpy(b) - gas.enthalpy(a)) / (b - a);
            prop_assert!((gas.mean_heat_capacity(a, b) / quotient - 1.0).abs() < 1e-10);
            let at = gas.mean_heat_capacity(a, a);
            prop_assert!((at / gas.heat_capacity(a) - 1.0).abs() < 1e-13);
        }

        #[test]
        fn prop_temperature_inverts_enthalpy(t in 900.0..1400.0f64) {
            let gas = Gas::products(0.016);
            let found = gas.temperature_k(gas.enthalpy(t), 1140.0, 3);
            prop_assert!((found - t).abs() < 1e-8, "{found} {t}");
        }

        #[test]
        fn prop_isentropic_compression_keeps_entropy(t in 230.0..330.0f64, ratio in 1.0..20.0f64) {
            let rise = air::entropy(air::isentropic_k(t, ratio)) - air::entropy(t);
            prop_assert!((rise - GAS_CONSTANT_J_KG_K * ratio.ln()).abs() < 1e-9);
        }
    }
}
