//! Air and combustion products as ideal gases with temperature-dependent heat capacity.
//!
//! The polynomial of air holds for 200 K to 2000 K; the term for products is linear in
//! temperature and proportional to the mass fraction of burnt fuel (spec section 2, assumed).

/// Specific gas constant of air, J/(kg K); also used for products, whose fuel share is below 2 %.
pub const GAS_CONSTANT_J_KG_K: f64 = 287.05;

/// Coefficients of the heat capacity of air, J/(kg K) per power of K.
const AIR: [f64; 5] = [1057.5, -0.4489, 1.1407e-3, -7.9999e-7, 1.9327e-10];

/// Coefficients of the extra heat capacity of products per fuel mass fraction.
const PRODUCTS: [f64; 2] = [750.0, 1.16];

/// A mixture of air and burnt fuel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gas {
    coefficients: [f64; 5],
}

impl Gas {
    /// Pure air.
    pub const AIR: Self = Self { coefficients: AIR };

    /// Air with `fuel_air_ratio` kilograms of burnt fuel per kilogram of air.
    pub fn products(fuel_air_ratio: f64) -> Self {
        let fraction = fuel_air_ratio / (1.0 + fuel_air_ratio);
        let mut coefficients = AIR;
        coefficients[0] += fraction * PRODUCTS[0];
        coefficients[1] += fraction * PRODUCTS[1];
        Self { coefficients }
    }

    /// Heat capacity at constant pressure, J/(kg K).
    pub fn heat_capacity(&self, temperature_k: f64) -> f64 {
        let [a0, a1, a2, a3, a4] = self.coefficients;
        let t = temperature_k;
        a0 + t * (a1 + t * (a2 + t * (a3 + t * a4)))
    }

    /// Specific enthalpy, J/kg: the integral of the heat capacity from 0 K.
    pub fn enthalpy(&self, temperature_k: f64) -> f64 {
        let [a0, a1, a2, a3, a4] = self.coefficients;
        let t = temperature_k;
        t * (a0 + t * (a1 / 2.0 + t * (a2 / 3.0 + t * (a3 / 4.0 + t * (a4 / 5.0)))))
    }

    /// Mean heat capacity between two temperatures, J/(kg K).
    ///
    /// The difference quotient of the enthalpy, factored so that equal temperatures need no
    /// division by zero.
    pub fn mean_heat_capacity(&self, from_k: f64, to_k: f64) -> f64 {
        let [a0, a1, a2, a3, a4] = self.coefficients;
        let sum = from_k + to_k;
        let squares = from_k * from_k + to_k * to_k;
        let product = from_k * to_k;
        let fourth = squares * squares + product * (squares - product);
        a0 + a1 / 2.0 * sum
            + a2 / 3.0 * (squares + product)
            + a3 / 4.0 * sum * squares
            + a4 / 5.0 * fourth
    }

    /// Ratio of heat capacities, cp / (cp - R).
    pub fn heat_capacity_ratio(&self, temperature_k: f64) -> f64 {
        let cp = self.heat_capacity(temperature_k);
        cp / (cp - GAS_CONSTANT_J_KG_K)
    }

    /// The temperature at which the enthalpy is `enthalpy_j_kg`, by `steps` of Newton from
    /// `start_k`. The heat capacity varies slowly, so each step at least doubles the digits.
    pub fn temperature_k(&self, enthalpy_j_kg: f64, start_k: f64, steps: usize) -> f64 {
        let mut t = start_k;
        for _ in 0..steps {
            t -= (self.enthalpy(t) - enthalpy_j_kg) / self.heat_capacity(t);
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
        assert!((Gas::AIR.heat_capacity(300.0) - 1005.5).abs() < 2.0);
        assert!((Gas::AIR.heat_capacity_ratio(300.0) - 1.4).abs() < 0.002);
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
            prop_assert!((found - t).abs() < 1e-6, "{found} {t}");
        }
    }
}
