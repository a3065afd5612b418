//! What realizable matter makes of realizable light is realizable; where modes of a hard edge are cut off, it is said how
//! far they are from it.

use csdm::JonesMatrix;
use mueller16::{Autocorrelation, Energy, Geometry, Matter, MatterError, Population, Tolerance};
use nalgebra::{Matrix2, Matrix4, Vector2};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{
    Components, Envelope, GaussianPeak, GeneralizedStokes, ModeWidth, Mueller, StokesVector,
};

use crate::tools::{blazed, light, oblique, outgoing_frame, root_of_size, series};

/// The Mueller matrix of up to three Jones matrices with weights.
fn mueller(entries: &[[f64; 8]], weights: &[f64]) -> Mueller {
    let sum: Matrix4<f64> = entries
        .iter()
        .zip(weights)
        .map(|(e, weight)| {
            let z = |i: usize| Complex64::new(e[2 * i], e[2 * i + 1]);
            JonesMatrix::new(z(0), z(1), z(2), z(3))
                .mueller()
                .to_matrix()
                * *weight
        })
        .sum();
    sum.into()
}

fn entries() -> impl Strategy<Value = [f64; 8]> {
    // near-degenerate ones too: polarizers, nothing
    prop_oneof![
        prop::array::uniform8(-1.0..1.0f64),
        Just([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Just([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1e-9]),
    ]
}

/// Stokes vectors up to and on the cone.
fn stokes() -> impl Strategy<Value = StokesVector> {
    let degree = prop_oneof![Just(1.0), Just(0.0), 0.0..1.0f64];
    (degree, 0.0..std::f64::consts::PI, -1.0..1.0f64).prop_map(|(p, a, s3)| {
        let linear = p * (1.0 - s3 * s3).sqrt();
        let (sin, cos) = (2.0 * a).sin_cos();
        StokesVector::new(1.0, linear * cos, linear * sin, p * s3)
    })
}

fn peak(p: [f64; 4]) -> GaussianPeak {
    let root = root_of_size(60.0 * (0.3 + p[3].abs()));
    GaussianPeak {
        peak: 0.1 + p[0].abs(),
        centre: Vector2::new(p[1], p[2]) * 1e-4,
        covariance: root.transpose() * root,
    }
}

fn scattered(
    matter: &Matter,
    geometry: &Geometry,
    incident: &GeneralizedStokes,
    order: usize,
) -> Vec<GeneralizedStokes> {
    let modes = matter.modes(ModeWidth::VarianceMatched, order).unwrap();
    matter
        .scatter(
            &modes,
            geometry,
            incident,
            Energy::HeightSurface,
            outgoing_frame(geometry),
            0.7,
        )
        .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn realizable_matter_makes_realizable_light(
        jones in prop::collection::vec(entries(), 1..4), weights in prop::array::uniform3(0.0..1.0f64),
        more in prop::collection::vec(entries(), 1..4), stokes in stokes(),
        peaks in prop::array::uniform3(prop::array::uniform4(-1.0..1.0f64)),
        phi in prop::array::uniform2(-2e5..2e5f64), at in prop::array::uniform2(-3.0..3.0f64),
    ) {
        let weights = weights.map(|w| w + 0.01);
        let geometry = oblique(phi);
        let wide = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(3e-11)).unwrap();
        let envelope = |p: [f64; 4]| Envelope::mixture(&[peak(p)]).unwrap();
        // one response over three Gaussians of a mixture, another over the first of them
        let (a, b) = (mueller(&jones, &weights), mueller(&more, &weights));
        let mut populations: Vec<_> = peaks
            .iter()
            .map(|p| Population::of_mueller(&a, blazed(), envelope(*p)).unwrap())
            .collect();
        populations.push(Population::of_mueller(&b, wide, envelope(peaks[0])).unwrap());
        let matter = Matter::new(populations).unwrap();
        let place = Vector2::from(phi) * 0.7;
        prop_assert!(matter.check_realizable(&[place, -place, geometry.tangential()], 1e-9).is_ok());
        let incident = light(&geometry, Components::Shared { modes: series(0, 0.0), stokes });
        for part in scattered(&matter, &geometry, &incident, 0) {
            // pure states are on the cone to the rounding of some products of sixteen numbers
            let report = part.realizability();
            prop_assert!(report.is_realizable(1e-12), "{report}");
            let y = Vector2::from(at);
            let position = part.shape().root().transpose() * y;
            let radiance = part.generalized_radiance(&position);
            prop_assert!(radiance.is_physical(1e-12), "{radiance:?}");
        }
    }
}

#[test]
fn modes_of_a_mixture_are_realizable_to_their_truncation() {
    let geometry = oblique([3e4, -2e4]);
    let peaks = [[0.5, 0.4, -0.1, 0.5], [0.2, -0.5, 0.3, 0.3]].map(peak);
    let polarizer = JonesMatrix::linear_polarizer().rotated(0.3);
    let matter = Matter::new(vec![Population::of_jones(
        &polarizer,
        blazed(),
        Envelope::mixture(&peaks).unwrap(),
    )])
    .unwrap();
    let incident = light(
        &geometry,
        Components::Shared {
            modes: series(0, 0.0),
            stokes: StokesVector::UNPOLARIZED,
        },
    );
    for asked in [1e-2, 1e-4, 1e-6] {
        let tolerance = Tolerance::relative(asked).unwrap();
        let (modes, choice) = matter
            .modes_for(ModeWidth::VarianceMatched, tolerance, 80)
            .unwrap();
        assert!(choice[0].reached, "{choice:?}");
        let order = modes[0].series().order();
        let report = scattered(&matter, &geometry, &incident, order)[0].realizability();
        // what is missing is a sum of modes, none larger than 1/√π, of orders up to about N + 32: their L² norm times the root of
        // their number bounds it, beside a peak that is a third of the norm at least
        let bound = 3.0 * choice[0].error * (32.0 * (order + 32) as f64).sqrt()
            / std::f64::consts::PI.sqrt();
        assert!(report.is_realizable(bound), "{asked:e}: {report}");
    }
}

#[test]
fn truncated_hard_edges_say_how_negative_they_are() {
    let geometry = oblique([3e4, -2e4]);
    let incident = light(
        &geometry,
        Components::Shared {
            modes: series(0, 0.0),
            stokes: StokesVector::RIGHT_CIRCULAR,
        },
    );
    for envelope in [
        Envelope::rectangle(2e-4, 1e-4).unwrap(),
        Envelope::disk(1e-4).unwrap(),
    ] {
        let matter = Matter::new(vec![Population::of_jones(
            &JonesMatrix::identity(),
            blazed(),
            envelope,
        )])
        .unwrap();
        let at = |order| scattered(&matter, &geometry, &incident, order)[0].realizability();
        // one Gaussian is nowhere negative
        assert!(at(0).is_realizable(1e-12));
        for order in [8, 16, 32] {
            let report = at(order);
            let negative = report.negative_radiance.unwrap();
            assert!(
                (0.01..0.5).contains(&negative.relative),
                "{order}: {report}"
            );
            assert!(!report.is_realizable(0.9 * negative.relative));
            assert!(
                report.to_string().contains("the radiance is negative by"),
                "{report}"
            );
            // polarized as it should be at zero separation all the same
            assert!(report.stokes_excess() < 1e-12);
        }
    }
}

#[test]
fn matter_that_no_ensemble_makes_is_refused() {
    let impossible = Mueller::from_rows([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
    ]);
    let envelope = Envelope::disk(1e-4).unwrap();
    let error = Population::of_mueller(&impossible, blazed(), envelope.clone()).unwrap_err();
    assert!(matches!(error, MatterError::NotRealizable(_)));
    // possible where the points are one, not for every direction: S3 kept by a wider lobe than S0
    let diagonal = |l: usize| {
        let mut m = Matrix4::zeros();
        m[(l, l)] = 1.0;
        Mueller::from(m)
    };
    let lobe =
        |size: f64| Autocorrelation::gaussian(&Matrix2::from_diagonal_element(size)).unwrap();
    let population = |l, r| Population::of_sixteen(&diagonal(l), r, envelope.clone());
    let matter = |narrow: f64| {
        let mut all = vec![population(3, lobe(narrow))];
        all.extend((0..3).map(|l| population(l, lobe(1e-10))));
        Matter::new(all).unwrap()
    };
    let places: Vec<_> = (0..6)
        .map(|i| Vector2::new(f64::from(i) * 1e5, 0.0))
        .collect();
    assert!(matter(1e-10).check_realizable(&places, 1e-9).is_ok());
    assert!(
        matter(0.5e-10)
            .check_realizable(&places[..1], 1e-9)
            .is_err()
    );
    assert!(
        matter(0.5e-10)
            .check_realizable(&places[3..], 1e-9)
            .is_err()
    );
}

#[test]
fn lobes_that_differ_in_their_tails_are_told_apart_there() {
    let envelope = Envelope::disk(1e-4).unwrap();
    let population = |l: usize, weight: f64, size: f64| {
        let mut m = Matrix4::zeros();
        m[(l, l)] = weight;
        let r = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(size)).unwrap();
        Population::of_sixteen(&m.into(), r, envelope.clone())
    };
    // S3 has 15 % of the lobe of S0 at the centre, and more than all of it beyond 3 standard deviations
    let wide = vec![population(0, 1.0, 1e-10), population(3, 0.3, 0.5e-10)];
    let wide = Matter::new(wide).unwrap();
    assert!(wide.check_realizable(&[Vector2::zeros()], 1e-9).is_ok());
    assert!(wide.check_realizable(&wide.lobe_places(), 1e-9).is_err());
    let same = vec![population(0, 1.0, 1e-10), population(3, 0.3, 1e-10)];
    let same = Matter::new(same).unwrap();
    assert_eq!(same.lobe_places().len(), 13);
    assert!(same.check_realizable(&same.lobe_places(), 1e-9).is_ok());
}

#[test]
fn matter_of_numbers_that_are_none_is_refused() {
    let envelope = Envelope::disk(1e-4).unwrap();
    let one = Mueller::identity();
    for bad in [f64::NAN, f64::INFINITY] {
        let dark = Mueller::from_rows([[bad; 4]; 4]);
        let parts = [
            (dark, Autocorrelation::constant(1.0), "element"),
            (one, Autocorrelation::constant(bad), "weight"),
            (one, blazed().scaled(bad), "weight"),
            (one, blazed().shifted(&Vector2::new(0.0, bad)), "shift"),
        ];
        for (mueller, r, what) in parts {
            let good = Population::of_sixteen(&one, blazed(), envelope.clone());
            let part = Population::of_sixteen(&mueller, r, envelope.clone());
            let text = Matter::new(vec![good, part]).unwrap_err().to_string();
            assert!(
                text.contains(what) && text.contains("population 1"),
                "{text}"
            );
        }
        assert!(Population::of_mueller(&dark, blazed(), envelope.clone()).is_err());
    }
}
