//! Poles as arguments.

use nalgebra::Complex;
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyComplexMethods};

/// A real or complex number.
#[derive(Clone, Copy)]
pub struct Pole(Complex<f64>);

impl<'py> FromPyObject<'_, 'py> for Pole {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        // NumPy's double-precision complex numbers are Python's.
        let (re, im) = match value.cast::<PyComplex>() {
            Ok(pole) => (pole.real(), pole.imag()),
            Err(_) => (value.extract()?, 0.0),
        };
        Ok(Self(Complex { re, im }))
    }
}

/// A number for all states, or one for each.
#[derive(FromPyObject, Clone)]
pub enum Poles {
    /// One for all.
    #[pyo3(annotation = "float")]
    One(Pole),
    /// One a state.
    #[pyo3(annotation = "list of float or complex")]
    Many(Vec<Pole>),
}

impl Poles {
    /// The poles of an observer with `nx` states.
    pub fn of(&self, nx: usize) -> Vec<Complex<f64>> {
        match self {
            Self::One(pole) => vec![pole.0; nx],
            Self::Many(poles) => poles.iter().map(|pole| pole.0).collect(),
        }
    }
}

/// A pole as Python writes it, without the imaginary part of a real one.
pub fn python_text(pole: Complex<f64>) -> String {
    if pole.im == 0.0 {
        format!("{:?}", pole.re)
    } else {
        format!("{:?}{:+?}j", pole.re, pole.im)
    }
}
