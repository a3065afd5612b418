//! Channels without the Gaussians whose lobes are too far from the encounter to matter.
//!
//! With z and M as the recurrence over the modes has them, the modes of total order n of one Gaussian are a symmetric
//! tensor `g⁽ⁿ⁾`, and since no eigenvalue of M exceeds 1 in modulus
//!
//! ```text
//! ‖g⁽ⁿ⁺¹⁾‖ ≤ √(2/(n+1)) |z| ‖g⁽ⁿ⁾‖ + ‖g⁽ⁿ⁻¹⁾‖,        |Σ s_ab g_ab| ≤ Σ_n ‖s⁽ⁿ⁾‖ ‖g⁽ⁿ⁾‖
//! ```
//!
//! which is N steps where the sum itself is N²/2.

use nalgebra::Vector2;
use smallvec::SmallVec;

use crate::accuracy::Tolerance;
use crate::autocorrelation::{Autocorrelation, GaussianFamily, GaussianTerm};
use crate::channels::Channels;
use crate::geometry::Geometry;
use crate::incident::IncidentCoherence;
use crate::kernel::{GaussianLobe, Meeting};
use crate::theorem::InteractionError;

/// What was left out of a set of channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropped {
    /// Number of Gaussians.
    pub terms: usize,
    /// Bound on the error of any number of the transfer, over the largest that the same Gaussians reach at the centres of
    /// their lobes.
    pub error: f64,
}

/// A Gaussian: group, family and term that it is, and the bound on what it adds.
struct Candidate {
    place: [usize; 3],
    bound: f64,
}

impl Channels {
    /// These channels without the Gaussians (orders of a grating, terms of a rough surface) whose lobes are so far away from this
    /// encounter that together they change no number by more than the tolerance, relative to the sum of the values
    /// at the centres of all lobes.
    ///
    /// What is left keeps its order and its bits. For a geometry that stays near this one, the result can be used again.
    ///
    /// # Errors
    ///
    /// When an autocorrelation that does not decay meets a plane wave.
    pub fn near(
        &self,
        geometry: &Geometry,
        light: &IncidentCoherence,
        tolerance: Tolerance,
    ) -> Result<(Self, Dropped), InteractionError> {
        let phi = geometry.tangential();
        let (root, determinant) = (light.root(), light.root_determinant());
        let norms = order_norms(light);
        let mut candidates = vec![];
        let mut peaks = 0.0;
        for (i, group) in self.groups().iter().enumerate() {
            let strength = group.mueller.amax();
            for (j, family) in group.autocorrelation.families().iter().enumerate() {
                let meeting = Meeting::new(family, root, determinant);
                for (k, lobe) in meeting.lobes(&phi).enumerate() {
                    let lobe = lobe.ok_or(InteractionError::Delta { determinant })?;
                    candidates.push(Candidate {
                        place: [i, j, k],
                        bound: strength * bound(&lobe, &norms),
                    });
                }
                let centred = centred(family);
                let meeting = Meeting::new(&centred, root, determinant);
                for lobe in meeting.lobes(&Vector2::zeros()).flatten() {
                    let [value] = crate::kernel::contract(&lobe, [Some(light.modes())]);
                    peaks += strength * value.abs();
                }
            }
        }
        candidates.sort_by(|a, b| a.bound.total_cmp(&b.bound));
        let allowed = tolerance.get() * peaks;
        let (mut lost, mut out) = (0.0, vec![]);
        for candidate in candidates {
            if lost + candidate.bound > allowed {
                break;
            }
            lost += candidate.bound;
            out.push(candidate.place);
        }
        let dropped = Dropped {
            terms: out.len(),
            error: if lost > 0.0 { lost / peaks } else { 0.0 },
        };
        Ok((self.without(&out), dropped))
    }

    /// The channels without the Gaussians at these places.
    fn without(&self, out: &[[usize; 3]]) -> Self {
        let mut kept = Self::default();
        for (i, group) in self.groups().iter().enumerate() {
            let families = group.autocorrelation.families().iter().enumerate();
            let sum = families.fold(Autocorrelation::default(), |sum, (j, family)| {
                let terms = family.terms().iter().enumerate();
                let terms = terms.filter(|(k, _)| !out.contains(&[i, j, *k]));
                let terms: SmallVec<_> = terms.map(|(_, term)| *term).collect();
                if terms.is_empty() {
                    sum
                } else {
                    sum.plus(&family.with_terms(terms).into())
                }
            });
            if sum.term_count() > 0 {
                kept = kept.with(&group.mueller.into(), sum, group.envelope);
            }
        }
        kept
    }
}

/// The same Gaussians with all lobes about 0.
fn centred(family: &GaussianFamily) -> GaussianFamily {
    let terms = family.terms().iter();
    family.with_terms(
        terms
            .map(|term| GaussianTerm::centred(term.weight, term.rate))
            .collect(),
    )
}

/// `‖s⁽ⁿ⁾‖` of the modes of each total order.
fn order_norms(light: &IncidentCoherence) -> Vec<f64> {
    let modes = light.modes();
    (0..=modes.order())
        .map(|n| {
            let squares = (0..=n).map(|b| modes.real_coefficient(n - b, b).powi(2));
            squares.sum::<f64>().sqrt()
        })
        .collect()
}

/// The bound on `|Σ s_ab g_ab|`.
fn bound(lobe: &GaussianLobe, norms: &[f64]) -> f64 {
    let z = lobe.z[0].hypot(lobe.z[1]);
    let (mut last, mut g) = (0.0, lobe.start.abs());
    let mut sum = 0.0;
    for (n, norm) in norms.iter().enumerate() {
        sum += norm * g;
        let next = (2.0 / (n + 1) as f64).sqrt() * z * g + last;
        (last, g) = (g, next);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector3};
    use proptest::prelude::*;
    use stokes::{HermiteSeries, Mueller, Wavelength, mode_count};

    fn light(seed: f64, order: usize, root: Matrix2<f64>) -> IncidentCoherence {
        let real: Vec<f64> = (0..mode_count(order))
            .map(|i| {
                if i == 0 {
                    9.0
                } else {
                    (seed + 1.7 * i as f64).sin()
                }
            })
            .collect();
        let modes = HermiteSeries::from_real_coefficients(&real).unwrap();
        IncidentCoherence::new(root, &modes).unwrap()
    }

    proptest! {
        #[test]
        fn no_gaussian_exceeds_its_bound(
            order in 0usize..12, seed in 0.0..6.0f64,
            d in prop::array::uniform4(-1.0..1.0f64), v in prop::array::uniform4(-1.0..1.0f64),
            scale in -3.0..3.0f64, phi in prop::array::uniform2(-9.0..9.0f64), rate in 0.1..4.0f64,
        ) {
            let d = Matrix2::from_row_slice(&d) + Matrix2::identity() * 1.5;
            let v = (Matrix2::from_row_slice(&v) + Matrix2::identity() * 1.5) * scale.exp();
            let family = GaussianFamily::new(&d, [GaussianTerm::centred(-0.7, rate)]).unwrap();
            let light = light(seed, order, v);
            let meeting = Meeting::new(&family, light.root(), light.root_determinant());
            let lobe = meeting.lobes(&phi.into()).next().unwrap().unwrap();
            let [value] = crate::kernel::contract(&lobe, [Some(light.modes())]);
            prop_assert!(value.abs() <= bound(&lobe, &order_norms(&light)) * (1.0 + 1e-12));
        }
    }

    #[test]
    fn the_bound_is_reached() {
        // a plane wave's own series; and the first order along φ, where g_1 = √2 z g_0
        let family =
            GaussianFamily::new(&Matrix2::identity(), [GaussianTerm::centred(1.0, 1.0)]).unwrap();
        let modes = HermiteSeries::from_real_coefficients(&[1.0, 1.0, 0.0]).unwrap();
        let light = IncidentCoherence::new(Matrix2::identity(), &modes).unwrap();
        let meeting = Meeting::new(&family, light.root(), light.root_determinant());
        let lobe = meeting
            .lobes(&Vector2::new(2.0, 0.0))
            .next()
            .unwrap()
            .unwrap();
        let [value] = crate::kernel::contract(&lobe, [Some(light.modes())]);
        assert!((value / bound(&lobe, &order_norms(&light)) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_dropped_changes_nothing_beyond_the_tolerance() {
        let green = Wavelength::from_metres(550e-9).unwrap();
        let pitch = 5e-6;
        let g = std::f64::consts::TAU / pitch;
        let terms = (-8..=8).map(|q| GaussianTerm {
            weight: 1.0 / f64::from(1 + q * q),
            rate: 1.0,
            shift: Vector2::new(f64::from(q) * g, 0.0),
        });
        let r = Autocorrelation::of_family(&Matrix2::from_diagonal_element(10e-6), terms).unwrap();
        let m = Mueller::from_rows([
            [1.0, 0.2, 0.0, 0.0],
            [0.1, -0.8, 0.0, 0.0],
            [0.0, 0.0, 0.5, 0.3],
            [0.0, 0.0, -0.3, 0.5],
        ]);
        let channels = Channels::new(&m, r);
        let light = light(0.3, 6, Matrix2::from_diagonal_element(4e4));
        let straight = Geometry::on_plane(Vector3::z(), Vector3::z(), green).unwrap();
        let at = |geometry: &Geometry, channels: &Channels| {
            channels
                .transfer(geometry, &light)
                .unwrap()
                .total()
                .to_matrix()
        };
        let peaks: f64 = (-8..=8)
            .map(|q| {
                let place = straight
                    .observed_at(&Vector2::new(f64::from(q) * g, 0.0))
                    .unwrap();
                let one = Channels::new(
                    &m,
                    Autocorrelation::of_family(
                        &Matrix2::from_diagonal_element(10e-6),
                        [GaussianTerm {
                            weight: 1.0 / f64::from(1 + q * q),
                            rate: 1.0,
                            shift: Vector2::new(f64::from(q) * g, 0.0),
                        }],
                    )
                    .unwrap(),
                );
                at(&place, &one).amax()
            })
            .sum();
        for tolerance in [1e-2, 1e-6, 1e-12] {
            let geometry = straight
                .observed_at(&Vector2::new(2.2 * g, 0.3 * g))
                .unwrap();
            let asked = Tolerance::relative(tolerance).unwrap();
            let (near, dropped) = channels.near(&geometry, &light, asked).unwrap();
            assert!(dropped.terms > 5, "{dropped:?}");
            assert!(dropped.error <= tolerance);
            let change = (at(&geometry, &channels) - at(&geometry, &near)).amax();
            // beside the dropped ones the sum of 17 numbers is rounded in another order
            assert!(
                change <= (dropped.error + 32.0 * f64::EPSILON) * peaks,
                "{change} {dropped:?}"
            );
        }
        let (all, dropped) = channels
            .near(&straight, &light, Tolerance::ROUNDING)
            .unwrap();
        let far = (at(&straight, &channels) - at(&straight, &all)).amax();
        assert!(far <= (dropped.error + 32.0 * f64::EPSILON) * peaks);
    }
}
