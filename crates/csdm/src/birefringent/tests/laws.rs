//! Laws that every plate obeys: energy, reciprocity, agreement with films and between the two ways to sum reflections.

use super::*;
use crate::birefringent::generator::Generator;
use crate::birefringent::half_space::{self, Directions, HalfSpace};
use crate::birefringent::scattering::Scattering;
use crate::film;
use crate::fresnel::normal_index_of;
use nalgebra::{Matrix2, Matrix3, Matrix6, SymmetricEigen, Vector3};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn vector() -> impl Strategy<Value = Vector3<f64>> {
    let component = || prop_oneof![4 => -1.0..1.0f64, 1 => Just(0.0), 1 => -1e-9..1e-9f64];
    (component(), component(), component()).prop_map(|(x, y, z)| Vector3::new(x, y, z))
}

/// Indices that differ, coincide, or nearly do.
fn indices() -> impl Strategy<Value = [f64; 3]> {
    let n = 1.1..2.5f64;
    let near = prop_oneof![Just(0.0), -1e-13..1e-13f64, -1e-9..1e-9f64, -1e-5..1e-5f64];
    prop_oneof![
        4 => [n.clone(), n.clone(), n.clone()],
        1 => (n.clone(), n.clone()).prop_map(|(a, b)| [a, a, b]),
        1 => (n, near.clone(), near).prop_map(|(a, e, f)| [a, a + e, a + f]),
    ]
}

fn extinction() -> impl Strategy<Value = [f64; 3]> {
    let k = || prop_oneof![2 => 0.0..0.3f64, 1 => Just(0.0), 1 => 0.0..1e-9f64];
    [k(), k(), k()]
}

fn gyration() -> impl Strategy<Value = Matrix3<f64>> {
    let g = prop::array::uniform6(-0.05..0.05f64);
    prop_oneof![
        Just(Matrix3::zeros()),
        g.prop_map(|g| Matrix3::new(g[0], g[1], g[2], g[1], g[3], g[4], g[2], g[4], g[5])),
    ]
}

fn crystal_of(k: impl Strategy<Value = [f64; 3]>) -> impl Strategy<Value = Crystal> {
    (indices(), k, vector(), vector(), gyration()).prop_filter_map("axes", |(n, k, a, b, g)| {
        let indices = [0, 1, 2].map(|i| Complex64::new(n[i], -k[i]));
        Crystal::biaxial(indices, a, b).ok()?.with_gyration(&g).ok()
    })
}

fn lossless() -> impl Strategy<Value = Crystal> {
    crystal_of(Just([0.0; 3]))
}

fn absorbing() -> impl Strategy<Value = Crystal> {
    crystal_of(extinction())
}

fn layers(
    crystal: impl Strategy<Value = Crystal>,
    thickest: f64,
) -> impl Strategy<Value = Vec<CrystalLayer>> {
    let depth = prop_oneof![4 => 0.0..2.0f64, 1 => Just(0.0), 1 => 0.0..thickest];
    let layer = (crystal, depth).prop_map(|(crystal, depth)| CrystalLayer {
        crystal,
        thickness: depth * LAMBDA,
    });
    prop::collection::vec(layer, 0..4)
}

fn cosine() -> impl Strategy<Value = f64> {
    prop_oneof![6 => 0.01..=1.0, 1 => Just(1.0), 1 => 1.0 - 1e-9..=1.0]
}

/// `R†R + w T†T`, whose eigenvalues are the shares of power that leave the stack.
fn power(side: &JonesSide) -> Matrix2<Complex64> {
    let (r, t) = (side.reflection.to_matrix(), side.transmission.to_matrix());
    r.adjoint() * r + t.adjoint() * t * Complex64::from(side.power_weight[0])
}

/// What roundings are worth that act as changes of the optical depths k₀ d, of the largest of which `deepest` is a bound.
///
/// A hundred `f64::EPSILON (1 + k₀ d)`, a dozen operations in each of some ten doublings, times the change of all
/// matrices with the depth: the finesse next to a resonance.
fn rounding<const N: usize>(
    deepest: f64,
    deepened: impl Fn(f64) -> [Matrix2<Complex64>; N],
) -> f64 {
    const STEP: f64 = 1e-7;
    let (before, after) = (deepened(0.0), deepened(STEP));
    let changes = before.iter().zip(&after).map(|(a, b)| (a - b).norm());
    128.0 * f64::EPSILON * (1.0 + deepest) * changes.sum::<f64>() / STEP
}

/// The same for both sides of a stack.
fn rounding_of(
    deepest: f64,
    n1: f64,
    layers: &[CrystalLayer],
    exit: f64,
    incidence: &Incidence,
) -> f64 {
    rounding(deepest, |by| {
        let deepened = layers.iter().map(|layer| CrystalLayer {
            thickness: layer.thickness + by * LAMBDA / TAU,
            ..layer.clone()
        });
        let stack = CrystalStack::new(n1, deepened.collect(), exit.into()).unwrap();
        let plate = stack.coherent(incidence, light());
        let back = plate.back.unwrap_or(plate.front);
        [
            plate.front.reflection.to_matrix(),
            plate.front.transmission.to_matrix(),
            back.reflection.to_matrix(),
            back.transmission.to_matrix(),
        ]
    })
}

proptest! {
    #[test]
    fn isotropic_layers_are_films(
        n1 in 1.0..2.0f64, exit in 1.0..2.0f64, cos_i in cosine(), azimuth in -4.0..4.0f64,
        media in prop::collection::vec((0.2..2.5f64, prop_oneof![Just(0.0), 0.0..3.0f64], 0.0..2.0f64), 0..4),
    ) {
        let (mut films, mut crystals) = (vec![], vec![]);
        for (eta, k, depth) in media {
            let (index, thickness) = (Complex64::new(eta, -k), depth * LAMBDA);
            films.push(film::Layer { index, thickness });
            crystals.push(CrystalLayer { crystal: Crystal::isotropic(index).unwrap(), thickness });
        }
        let film = film::Stack::new(n1, films, exit.into()).unwrap().amplitudes(cos_i, light());
        let tolerance = 1e-12 + rounding_of(2.0 * TAU, n1, &crystals, exit, &at(cos_i, azimuth));
        let stack = CrystalStack::new(n1, crystals, exit.into()).unwrap();
        let plate = stack.coherent(&at(cos_i, azimuth), light()).front;
        prop_assert!(distance(&plate.reflection, &film.reflection()) < tolerance);
        // an evanescent field behind a resonance is the larger, and its error with the square
        let field = 1.0 + film.transmission().to_matrix().norm_squared();
        prop_assert!(distance(&plate.transmission, &film.transmission()) < tolerance * field);
        prop_assert_eq!(plate.power_weight, film.power_weight);
    }

    #[test]
    fn lossless_plates_conserve_power(
        n1 in 1.0..2.5f64, exit in 1.0..2.5f64, layers in layers(lossless(), 1e4), cos_i in cosine(),
        azimuth in -4.0..4.0f64,
    ) {
        let stack = CrystalStack::new(n1, layers.clone(), exit.into()).unwrap();
        let plate = stack.coherent(&at(cos_i, azimuth), light());
        for side in [Some(plate.front), plate.back].into_iter().flatten() {
            let error = (power(&side) - Matrix2::identity()).norm();
            // a phase takes no power, however deep
            let amplified = || rounding_of(0.0, n1, &layers, exit, &at(cos_i, azimuth));
            prop_assert!(error < 1e-12 || error < 1e-12 + amplified(), "{}", error);
        }
    }

    #[test]
    fn absorbing_plates_are_passive(
        n1 in 1.0..2.5f64, exit in 1.0..2.5f64, layers in layers(absorbing(), 1e4), cos_i in cosine(),
        azimuth in -4.0..4.0f64,
    ) {
        let plate = CrystalStack::new(n1, layers, exit.into()).unwrap().coherent(&at(cos_i, azimuth), light());
        for side in [Some(plate.front), plate.back].into_iter().flatten() {
            let most = SymmetricEigen::new(power(&side)).eigenvalues.max();
            prop_assert!(most <= 1.0 + 1e-12, "{}", most);
            prop_assert!(side.reflection_mueller().is_passive(1e-12));
            prop_assert!(side.transmission_mueller().unwrap().is_passive(1e-12));
        }
    }

    #[test]
    fn the_way_back_has_the_reversed_matrix(
        n1 in 1.0..2.5f64, exit in 1.0..2.5f64, layers in layers(absorbing(), 5.0), cos_i in cosine(),
        azimuth in -4.0..4.0f64,
    ) {
        // the reversed ray has the opposite tangential wave vector: azimuth + π
        // 4 f64::EPSILON k₀ d |M| is 2e-13 for each of three layers, of a few bounces; evanescent layers make resonators
        let tolerance = 2e-12 + rounding_of(5.0 * TAU, n1, &layers, exit, &at(cos_i, azimuth));
        let stack = CrystalStack::new(n1, layers, exit.into()).unwrap();
        let there = stack.coherent(&at(cos_i, azimuth), light());
        let again = stack.coherent(&at(cos_i, azimuth + PI), light());
        prop_assert!(distance(&again.front.reflection, &there.front.reflection.reversed()) < tolerance);
        let Some(back) = again.back else { return Ok(()) };
        let weight = Complex64::from(there.front.power_weight[0]);
        let reversed = there.front.transmission.reversed().to_matrix() * weight;
        prop_assert!((back.transmission.to_matrix() - reversed).norm() < tolerance * (1.0 + weight.re));
        prop_assert!(distance(&back.reflection, &there.back.unwrap().reflection.reversed()) < tolerance);
    }

    #[test]
    fn forward_and_backward_waves_solve_maxwells_equations(
        crystal in absorbing(), xi in 0.0..2.4f64, azimuth in -4.0..4.0f64,
    ) {
        // every index q of the waves makes the six equations κ×E = b, κ×h = −d singular
        let directions = Directions::new(&crystal, xi, azimuth);
        let seen = crystal.turned(-azimuth);
        let (m, s) = half_space::eigenvalues(&directions.forward);
        let (m2, s2) = half_space::eigenvalues(&directions.backward);
        for q in [m + s, m - s, m2 + s2, m2 - s2] {
            let curl = Matrix3::new(
                Complex64::ZERO, -q, xi.into(),
                q, Complex64::ZERO, Complex64::ZERO,
                (-xi).into(), Complex64::ZERO, Complex64::ZERO,
            );
            let coupling = seen.coupling().map(|k| Complex64::new(0.0, k));
            let mut system = Matrix6::zeros();
            system.fixed_view_mut::<3, 3>(0, 0).copy_from(&(curl + coupling));
            system.fixed_view_mut::<3, 3>(0, 3).copy_from(&-Matrix3::identity());
            system.fixed_view_mut::<3, 3>(3, 0).copy_from(&seen.permittivity());
            system.fixed_view_mut::<3, 3>(3, 3).copy_from(&(curl + coupling));
            let smallest = system.singular_values().min();
            // equal indices to rounding have roots good to the square root of it, and q² near 0 likewise
            prop_assert!(smallest < 2e-7, "{} {}", q, smallest);
        }
        // forward waves decay or carry power along +z
        prop_assert!((m + s).im < 1e-7 && (m - s).im < 1e-7);
        prop_assert!((m2 + s2).im > -1e-7 && (m2 - s2).im > -1e-7);
    }

    #[test]
    fn doubled_slices_agree_with_summed_bounces(
        crystal in absorbing(), n1 in 1.0..2.5f64, exit in 1.0..2.5f64, cos_i in cosine(), azimuth in -4.0..4.0f64,
        depth in 0.0..3.0f64,
    ) {
        // faces and propagation of the two subspaces, against slices that know of neither
        let incidence = at(cos_i, azimuth);
        let xi = incidence.tangential_index(n1);
        let directions = Directions::new(&crystal, xi, azimuth);
        let w = normal_index_of(n1.into(), exit.into(), cos_i);
        let before = HalfSpace::isotropic(n1.into(), (n1 * cos_i).into());
        let behind = HalfSpace::isotropic(exit.into(), w);
        let empty = Scattering::transparent();
        let bounces = empty.between(&before, &directions.waves)
            .then(&directions.propagation(TAU * depth))
            .then(&empty.between(&directions.waves, &behind));
        let generator = Generator::new(&crystal, xi, azimuth);
        let slices = |deeper: f64| {
            Scattering::of_layer(&generator, TAU * depth + deeper, crystal.is_lossless()).between(&before, &behind)
        };
        let doubled = slices(0.0);
        let amplified = rounding(TAU * depth, |deeper| {
            let all = slices(deeper);
            [all.reflection, all.transmission, all.back_reflection]
        });
        // 4 f64::EPSILON k₀ d |M| is 3e-13; forward and backward waves that nearly coincide are split to the root of
        // rounding
        let (m, s) = half_space::eigenvalues(&directions.forward);
        let gap = (m + s).norm().min((m - s).norm());
        let tolerance = 1e-12 + amplified + 1e-12 / gap.powi(3).max(1e-9);
        let error = (bounces.reflection - doubled.reflection).norm()
                + (bounces.transmission - doubled.transmission).norm()
            + (bounces.back_reflection - doubled.back_reflection).norm();
        prop_assert!(error < tolerance, "{} {}", error, gap);
    }

    #[test]
    fn incoherent_sums_conserve_power(
        n1 in 1.0..1.2f64, exit in 1.0..1.2f64, layers in layers(crystal_of(Just([0.0; 3])), 1e4), cos_i in cosine(),
        azimuth in -4.0..4.0f64,
    ) {
        // no total reflection inside, whose evanescent waves interfere: n above 1.2, and activity takes 0.1 off
        let dense = |l: &CrystalLayer| l.crystal.permittivity().map(|c| c.re).symmetric_eigenvalues().min() > 1.9;
        if !layers.iter().all(dense) {
            return Ok(());
        }
        // two waves of almost one index are told apart by rounding times k₀ d
        let tolerance = 1e-12 + 4.0 * f64::EPSILON * TAU * layers.iter().map(|l| l.thickness / LAMBDA).sum::<f64>();
        let stack = CrystalStack::new(n1, layers, exit.into()).unwrap();
        let sum = stack.incoherent(&at(cos_i, azimuth), light(), 0.0).unwrap();
        for side in [Some(sum.front), sum.back].into_iter().flatten() {
            let row = (side.reflection.to_matrix() + side.transmission.to_matrix()).row(0).into_owned();
            let error = (row - nalgebra::RowVector4::new(1.0, 0.0, 0.0, 0.0)).amax();
            prop_assert!(error < tolerance, "{}", error);
        }
    }
}

#[test]
fn reciprocity_holds_for_a_biaxial_absorbing_active_plate_at_27_degrees() {
    let crystal = Crystal::biaxial(
        [
            Complex64::new(1.5, -0.01),
            Complex64::new(1.6, -0.05),
            Complex64::new(1.75, -0.002),
        ],
        Vector3::new(0.3, -0.5, 0.8),
        Vector3::new(0.1, 0.9, 0.4),
    );
    let crystal = crystal
        .unwrap()
        .with_gyration(&(Matrix3::identity() * 0.02))
        .unwrap();
    let plate = CrystalLayer {
        crystal,
        thickness: 1.2 * LAMBDA,
    };
    let stack = CrystalStack::new(1.0, vec![plate], 1.0.into()).unwrap();
    let cos_i = 27f64.to_radians().cos();
    let there = stack.coherent(&at(cos_i, 0.4), light()).front;
    let back = stack.coherent(&at(cos_i, 0.4 + PI), light()).back.unwrap();
    assert!(distance(&back.transmission, &there.transmission.reversed()) < 2e-14);
    // plain transposition is no law
    let t = there.transmission.to_matrix().transpose();
    assert!((back.transmission.to_matrix() - t).norm() > 0.1);
}

#[test]
fn light_comes_from_the_back_only_where_waves_travel_there() {
    let layer = || CrystalLayer {
        crystal: Crystal::isotropic(1.4.into()).unwrap(),
        thickness: LAMBDA,
    };
    for (exit, cos_i, travels) in [
        (Complex64::new(1.5, 0.0), 0.5, true),
        (Complex64::new(1.0, 0.0), 0.5, false),
        (Complex64::new(0.2, -3.0), 1.0, false),
    ] {
        let stack = CrystalStack::new(1.5, vec![layer()], exit).unwrap();
        let jones = stack.coherent(&at(cos_i, 0.0), light());
        assert_eq!(jones.back.is_some(), travels);
        let absorbs = exit.im != 0.0;
        assert_eq!(jones.front.transmission_mueller().is_err(), absorbs);
        let sum = stack.incoherent(&at(cos_i, 0.0), light(), 0.0);
        assert_eq!(sum.is_err(), absorbs);
        assert!(sum.is_err() || sum.unwrap().back.is_some() == travels);
    }
}

#[test]
fn extreme_media_and_angles_stay_finite_and_passive() {
    let media = [
        (1e-3, 0.0),
        (0.05, 10.0),
        (100.0, 0.0),
        (0.0, 3.0),
        (1.0, 0.0),
        (1.0 + 1e-15, 1e-15),
        (3.0, 1e3),
    ];
    let axes = [Vector3::z(), Vector3::x(), Vector3::new(1.0, 2.0, 2.0)];
    for (eta, k) in media {
        for (eta2, k2) in media {
            for axis in axes {
                let (n, m) = (Complex64::new(eta, -k), Complex64::new(eta2, -k2));
                let crystal = Crystal::uniaxial(n, m, axis).unwrap();
                for depth in [0.0, 1e-12, 0.3, 1e4, 1e9] {
                    let plate = CrystalLayer {
                        crystal: crystal.clone(),
                        thickness: depth * LAMBDA,
                    };
                    let stack = CrystalStack::new(1.0, vec![plate], 1.0.into()).unwrap();
                    for cos_i in [0.0, 1e-9, 0.5, 1.0] {
                        let incidence = at(cos_i, 0.3);
                        let found = stack.coherent(&incidence, light()).front;
                        let r = found.reflection_mueller().to_matrix();
                        let t = found.transmission_mueller().unwrap().to_matrix();
                        let case = format!("{n} {m} {axis:?} {depth} {cos_i}");
                        assert!((r + t).iter().all(|x| x.is_finite()), "{case}");
                        // grazing light at media of equal index is told from reflected light by f64::EPSILON/cos θ
                        let tolerance = 1e-11 + 16.0 * f64::EPSILON / cos_i.max(1e-9);
                        let gain = (r + t)[(0, 0)] - 1.0;
                        assert!(gain < tolerance, "{case} {gain}");
                        let direct = stack.single_pass(&incidence, light()).front;
                        assert!(
                            direct
                                .transmission
                                .to_matrix()
                                .iter()
                                .all(|x| x.is_finite()),
                            "{case}"
                        );
                    }
                }
            }
        }
    }
}
