//! Where the theorem holds, and what is said where it does not.

use mueller16::{Domain, DomainError, Geometry};
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
