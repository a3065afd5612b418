//! Where the theorem holds: far field, paraxial sources, footprints that are small beside what they tell apart.
//!
//! The theorem takes matter for locally stationary and gives every point of the footprint the same pair of directions. A
//! footprint of extent a, correlated over l, sees directions that differ by `a/s` and `a/r`; over one correlation length
//! that is the phase `a l k/s`, which must stay small. The product of mean and difference coordinates is all that appears:
//! `a² k/r` may be anything.

use stokes::LEAST_FAR_FIELD;
use thiserror::Error;

use crate::geometry::{Geometry, LEAST_COSINE};

/// Largest angular radius of a source, or of a footprint as the observer sees it, that is taken for paraxial.
pub const MOST_PARAXIAL: f64 = 0.1;

/// Largest phase over a correlation length, rad, by which directions may differ across a footprint.
pub const MOST_PHASE: f64 = 0.3;

/// What takes an encounter out of the theorem's domain.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum DomainError {
    /// A length is not positive and finite, or a coherence length is negative.
    #[error("domain: the {what} is {value} m, expected {expected}")]
    Length {
        /// Which length.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What should be there.
        expected: &'static str,
    },
    /// A direction lies in the surface.
    #[error(
        "domain: the direction to the {to} is at cosine {cosine} from the normal, expected a modulus of at least 1e-9"
    )]
    Grazing {
        /// `"source"` or `"observer"`.
        to: &'static str,
        /// The cosine.
        cosine: f64,
    },
    /// Not in the far field.
    #[error(
        "domain: the {to} is at {distance} m, k r = {kr}, expected at least 100: the far-field expansion does not hold nearer; \
         follow the field itself over this distance"
    )]
    Near {
        /// `"source"` or `"observer"`.
        to: &'static str,
        /// Distance, m.
        distance: f64,
        /// `k r`.
        kr: f64,
    },
    /// A footprint is too large for its distance.
    #[error(
        "domain: the {what} has the half-extent {extent} m at {distance} m, an angular radius of {ratio}, expected at most 0.1: \
         subdivide it into at least {parts} parts along its longer side"
    )]
    NotParaxial {
        /// `"source"` or `"footprint"`.
        what: &'static str,
        /// Half-extent, m.
        extent: f64,
        /// Distance, m.
        distance: f64,
        /// Their ratio.
        ratio: f64,
        /// How many parts would do.
        parts: usize,
    },
    /// Directions differ too much across the footprint.
    #[error(
        "domain: across the footprint of half-extent {extent} m the direction to the {to} at {distance} m turns the phase over \
         the correlation length {correlation} m by {phase} rad, expected at most 0.3: subdivide the footprint into at least \
         {parts} parts along its longer side"
    )]
    NotStationary {
        /// `"source"` or `"observer"`.
        to: &'static str,
        /// Half-extent of the footprint, m.
        extent: f64,
        /// Correlation length of the matter under this light, m.
        correlation: f64,
        /// Distance, m.
        distance: f64,
        /// `a l k/r`, rad.
        phase: f64,
        /// How many parts would do.
        parts: usize,
    },
}

/// The lengths that decide whether an encounter is in the domain of Theorem S4.1, and the numbers that follow.
///
/// The wavenumbers are those of the media. Conventional bounds; the phases of stationarity are an analytic estimate.
///
/// ```
/// use mueller16::{Domain, Geometry};
/// use nalgebra::Vector3;
/// use stokes::Wavelength;
/// let green = Wavelength::from_metres(550e-9)?;
/// let normal = Geometry::on_plane(Vector3::z(), Vector3::z(), green)?;
/// // 1 mm of ground glass, correlated over 10 µm, between a 5 mm lamp at 1 m and an observer at 1 m
/// let glass = Domain { source: 5e-3, source_distance: 1.0, footprint: 0.5e-3, correlation: 10e-6, distance: 1.0 };
/// assert!(glass.check(&normal).is_ok());
/// // a l k/s = 0.5 mm · 10 µm · 1.14e7/m / 1 m
/// assert!((glass.phases(&normal)[0] - 0.0571).abs() < 1e-4);
/// // a tenth of the distance: twice what is allowed
/// let near = Domain { distance: 0.1, ..glass };
/// assert!(near.check(&normal).unwrap_err().to_string().contains("subdivide the footprint into at least 2 parts"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Half-extent of the source, m; 0 for a point.
    pub source: f64,
    /// Distance of the source, m.
    pub source_distance: f64,
    /// Half-extent of the footprint on the matter, m.
    pub footprint: f64,
    /// Correlation length of the matter under this light, m: the smaller of its own and the light's.
    pub correlation: f64,
    /// Distance of the observer, m.
    pub distance: f64,
}

impl Domain {
    /// `k r` of the way to the source and of that to the observer.
    #[must_use]
    pub fn far_field(&self, geometry: &Geometry) -> [f64; 2] {
        let [incident, outgoing] = wavenumbers(geometry);
        [incident * self.source_distance, outgoing * self.distance]
    }

    /// The phases `a l k/s` and `a l k/r`, rad, by which the directions to source and observer differ across the
    /// footprint, over a correlation length.
    ///
    /// The second is also the Fraunhofer condition: only the product of mean and difference coordinates appears in the
    /// phase, not `a² k/r`.
    #[must_use]
    pub fn phases(&self, geometry: &Geometry) -> [f64; 2] {
        let [incident, outgoing] = wavenumbers(geometry);
        let product = self.footprint * self.correlation;
        [
            product * incident / self.source_distance,
            product * outgoing / self.distance,
        ]
    }

    /// Whether the theorem holds for this encounter.
    ///
    /// # Errors
    ///
    /// The first of [`Domain::violations`].
    pub fn check(&self, geometry: &Geometry) -> Result<(), DomainError> {
        self.violations(geometry)
            .into_iter()
            .next()
            .map_or(Ok(()), Err)
    }

    /// Everything that takes this encounter out of the domain, with the numbers and the remedy; empty inside.
    #[must_use]
    pub fn violations(&self, geometry: &Geometry) -> Vec<DomainError> {
        let wrong: Vec<_> = self.lengths().collect();
        if !wrong.is_empty() {
            return wrong;
        }
        let mut found = vec![];
        let ends = [
            ("source", geometry.cos_incident(), self.source_distance),
            ("observer", geometry.cos_outgoing(), self.distance),
        ];
        for (to, cosine, _) in ends {
            if cosine.abs() < LEAST_COSINE {
                found.push(DomainError::Grazing { to, cosine });
            }
        }
        for ((to, _, distance), kr) in ends.into_iter().zip(self.far_field(geometry)) {
            if kr < LEAST_FAR_FIELD {
                found.push(DomainError::Near { to, distance, kr });
            }
        }
        for (what, extent, distance) in [
            ("source", self.source, self.source_distance),
            ("footprint", self.footprint, self.source_distance),
            ("footprint", self.footprint, self.distance),
        ] {
            let ratio = extent / distance;
            if ratio > MOST_PARAXIAL {
                let parts = parts(ratio / MOST_PARAXIAL);
                found.push(DomainError::NotParaxial {
                    what,
                    extent,
                    distance,
                    ratio,
                    parts,
                });
            }
        }
        for ((to, _, distance), phase) in ends.into_iter().zip(self.phases(geometry)) {
            if phase > MOST_PHASE {
                found.push(DomainError::NotStationary {
                    to,
                    extent: self.footprint,
                    correlation: self.correlation,
                    distance,
                    phase,
                    parts: parts(phase / MOST_PHASE),
                });
            }
        }
        found
    }

    fn lengths(&self) -> impl Iterator<Item = DomainError> {
        let (positive, least) = ("a finite positive number", "a finite number of at least 0");
        [
            ("distance of the source", self.source_distance, positive),
            ("distance of the observer", self.distance, positive),
            ("half-extent of the source", self.source, least),
            ("half-extent of the footprint", self.footprint, least),
            ("correlation length", self.correlation, least),
        ]
        .into_iter()
        .filter(move |(_, value, expected)| {
            !value.is_finite() || *value < 0.0 || (*expected == positive && *value == 0.0)
        })
        .map(|(what, value, expected)| DomainError::Length {
            what,
            value,
            expected,
        })
    }
}

fn wavenumbers(geometry: &Geometry) -> [f64; 2] {
    let k = geometry.wavelength().wavenumber().radians_per_metre();
    [k * geometry.n_incident(), k * geometry.n_outgoing()]
}

/// Whole parts that bring an excess down to 1.
fn parts(excess: f64) -> usize {
    excess.ceil() as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use stokes::Wavelength;

    const GOOD: Domain = Domain {
        source: 5e-3,
        source_distance: 1.0,
        footprint: 0.5e-3,
        correlation: 10e-6,
        distance: 1.0,
    };

    fn normal() -> Geometry {
        let light = Wavelength::from_metres(500e-9).unwrap();
        Geometry::on_plane(Vector3::z(), Vector3::z(), light).unwrap()
    }

    #[test]
    fn each_limit_is_found_where_it_is_passed_and_nowhere_else() {
        let g = normal();
        assert_eq!(GOOD.violations(&g), vec![]);
        let k = 4e6 * std::f64::consts::PI;
        // just inside and just outside of each limit
        for (inside, outside) in [
            (
                Domain {
                    source: 0.0999,
                    ..GOOD
                },
                Domain {
                    source: 0.1001,
                    ..GOOD
                },
            ),
            (
                Domain {
                    correlation: 0.299 / (k * 0.5e-3),
                    ..GOOD
                },
                Domain {
                    correlation: 0.301 / (k * 0.5e-3),
                    ..GOOD
                },
            ),
            (
                Domain {
                    footprint: 0.0,
                    distance: 101.0 / k,
                    ..GOOD
                },
                Domain {
                    footprint: 0.0,
                    distance: 99.0 / k,
                    ..GOOD
                },
            ),
        ] {
            assert_eq!(inside.check(&g), Ok(()));
            assert!(outside.check(&g).is_err());
        }
        // a² k/r = 3, far above 1, does no harm by itself
        assert!(GOOD.footprint.powi(2) * k > 3.0);
    }

    #[test]
    fn as_many_parts_as_the_error_says_are_enough() {
        let g = normal();
        for domain in [
            Domain {
                source: 0.73,
                ..GOOD
            },
            Domain {
                footprint: 20e-3,
                ..GOOD
            },
            Domain {
                footprint: 20e-3,
                distance: 0.2,
                ..GOOD
            },
            Domain {
                footprint: 1e-3,
                distance: 1e-3,
                correlation: 1e-7,
                ..GOOD
            },
        ] {
            let violations = domain.violations(&g);
            assert!(!violations.is_empty());
            let (mut source, mut footprint) = (1, 1);
            for violation in violations {
                match violation {
                    DomainError::NotParaxial {
                        what: "source",
                        parts,
                        ..
                    } => source = source.max(parts),
                    DomainError::NotParaxial { parts, .. }
                    | DomainError::NotStationary { parts, .. } => {
                        footprint = footprint.max(parts);
                    }
                    other => panic!("{other}"),
                }
            }
            let part = Domain {
                source: domain.source / source as f64,
                footprint: domain.footprint / footprint as f64,
                ..domain
            };
            assert_eq!(part.check(&g), Ok(()), "{domain:?}");
            // and one fewer is not
            if footprint > 1 {
                let footprint = domain.footprint / (footprint - 1) as f64;
                assert!(Domain { footprint, ..part }.check(&g).is_err());
            }
        }
    }

    #[test]
    fn errors_carry_the_numbers_and_the_remedy() {
        let g = normal();
        let text = Domain {
            source: 0.73,
            ..GOOD
        }
        .check(&g)
        .unwrap_err()
        .to_string();
        assert_eq!(
            text,
            "domain: the source has the half-extent 0.73 m at 1 m, an angular radius of 0.73, expected at most 0.1: \
             subdivide it into at least 8 parts along its longer side"
        );
        let text = Domain {
            distance: f64::NAN,
            ..GOOD
        }
        .check(&g)
        .unwrap_err()
        .to_string();
        assert_eq!(
            text,
            "domain: the distance of the observer is NaN m, expected a finite positive number"
        );
        let light = Wavelength::from_metres(500e-9).unwrap();
        let edge_on = Geometry::on_plane(Vector3::z(), Vector3::x(), light).unwrap();
        assert_eq!(
            GOOD.check(&edge_on),
            Err(DomainError::Grazing {
                to: "observer",
                cosine: 0.0
            })
        );
    }
}
