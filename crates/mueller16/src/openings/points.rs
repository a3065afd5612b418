//! Openings as points, by which Lemma 4.3 gives their outgoing Hermite-Gauss modes.

use nalgebra::Vector2;

use super::error::OpeningError;
use super::rules::legendre_rule;
use super::screen::Openings;
use crate::accuracy::Tolerance;
use crate::scatterers::{PointScatterer, PointScatterers};

/// Most points of a screen: their pairs are what is computed.
const MOST_POINTS: usize = 10_000;

impl Openings {
    /// Point scatterers that stand for these openings: Gauss-Legendre nodes in each of them, their weights as areas.
    ///
    /// The field of each opening is right to `tolerance` of its largest for wave vectors up to `reach`, rad/m along each
    /// tangent: add up what the geometry has (`φ_t`), the light, and half of the far-field arguments w that matter, which for
    /// outgoing modes of order N over a root W is `√(2N + 1) + 5` over its singular values. The cost of what follows grows
    /// with the square of the number of points.
    ///
    /// # Errors
    ///
    /// When the tolerance needs more than 10,000 points, or a reach is not a finite number.
    pub fn points(
        &self,
        reach: [f64; 2],
        tolerance: Tolerance,
    ) -> Result<PointScatterers, OpeningError> {
        let mut points = vec![];
        for opening in self.openings() {
            let [x, y] = [
                (reach[0], 0.5 * opening.width),
                (reach[1], 0.5 * opening.height),
            ]
            .map(|(reach, half)| legendre_rule(reach.abs() * half, 0.5 * tolerance.get()));
            let (x, y) = (x?, y?);
            let needed = points.len() + x.nodes.len() * y.nodes.len();
            if needed > MOST_POINTS {
                return Err(OpeningError::Value {
                    what: "the number of points",
                    value: needed as f64,
                    expected: "at most 10000: ask for less accuracy or a smaller reach",
                });
            }
            for (u, p) in &x.nodes {
                for (v, q) in &y.nodes {
                    let offset = Vector2::new(0.5 * opening.width * u, 0.5 * opening.height * v);
                    points.push(PointScatterer {
                        place: (opening.centre + offset).push(0.0),
                        strength: opening.area() * p * q,
                        jones: opening.jones,
                    });
                }
            }
        }
        Ok(PointScatterers::from_checked(points))
    }
}
