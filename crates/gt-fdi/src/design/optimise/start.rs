//! Where a search begins.

use nalgebra::DVector;
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::sections::Sections;

/// Where a descent began, or what else found the poles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Start {
    /// A vertex of the polytope of the radius: every section has both poles at plus the radius,
    /// both at minus it or one at each, and a first-order section either.
    Vertex {
        /// 0-based index among them.
        index: usize,
    },
    /// The same vertex of the polytope of a radius twice as far from 1, or half as large where that
    /// is larger: inside, where descents are not held by the faces.
    Inner {
        /// 0-based index among them.
        index: usize,
    },
    /// All poles at the same place on the real axis.
    Diagonal {
        /// The place.
        pole: f64,
    },
    /// Drawn from the polytope, uniformly in each section.
    Random {
        /// 0-based index of the draw.
        index: usize,
    },
    /// No descent: differential evolution over the whole polytope.
    Evolution,
}

/// The radius of the vertices that are starts inside the polytope.
pub(super) fn inner(radius: f64) -> f64 {
    (2.0 * radius - 1.0).max(radius / 2.0)
}

/// All vertices of the polytope, but for the order of the sections, which does not matter.
pub(super) fn vertices(order: usize, radius: f64) -> Vec<Sections> {
    let square = radius * radius;
    let corners = [
        [-2.0 * radius, square],
        [0.0, -square],
        [2.0 * radius, square],
    ];
    let count = order / 2;
    let singles: &[f64] = if order % 2 == 1 { &[-1.0, 1.0] } else { &[0.0] };
    let mut all = Vec::new();
    for first in 0..=count {
        for second in 0..=count - first {
            let third = count - first - second;
            for sign in singles {
                let sections = corners.into_iter().zip([first, second, third]);
                let mut coefficients: Vec<f64> = sections
                    .flat_map(|(corner, times)| std::iter::repeat_n(corner, times))
                    .flatten()
                    .collect();
                if order % 2 == 1 {
                    coefficients.push(sign * radius);
                }
                all.push(Sections::new(DVector::from_vec(coefficients)));
            }
        }
    }
    all
}

/// Places on the real axis, evenly spaced inside the radius.
pub(super) fn diagonal(count: usize, radius: f64) -> Vec<f64> {
    let step = 2.0 / (count + 1) as f64;
    (1..=count)
        .map(|k| radius * (k as f64 * step - 1.0))
        .collect()
}

/// Sections with all poles at the same place.
pub(super) fn equal(order: usize, pole: f64) -> Sections {
    let pattern = [-2.0 * pole, pole * pole];
    let coefficients = (0..order).map(|k| {
        if k + 1 == order && order % 2 == 1 {
            -pole
        } else {
            pattern[k % 2]
        }
    });
    Sections::new(DVector::from_iterator(order, coefficients))
}

/// Sections drawn uniformly from the polytope.
pub(super) fn random(order: usize, radius: f64, rng: &mut impl Rng) -> Sections {
    let cube: Vec<f64> = (0..order)
        .map(|k| {
            let draw: f64 = rng.random();
            // The triangle of a section widens with a2: as many points at each height as it is wide.
            if k % 2 == 1 { draw.sqrt() } else { draw }
        })
        .collect();
    from_cube(&cube, radius)
}

/// Sections from numbers between 0 and 1, of which the second of each section is the height in its
/// triangle and the first the place at that height; corners become vertices.
pub(super) fn from_cube(cube: &[f64], radius: f64) -> Sections {
    let mut coefficients = Vec::with_capacity(cube.len());
    for section in cube.chunks(2) {
        match *section {
            [across, height] => {
                let half_width = 2.0 * radius * height;
                coefficients.push(half_width * (2.0 * across - 1.0));
                coefficients.push(radius * radius * (2.0 * height - 1.0));
            }
            _ => coefficients.extend(section.iter().map(|place| radius * (2.0 * place - 1.0))),
        }
    }
    Sections::new(DVector::from_vec(coefficients)).clamped(radius)
}
