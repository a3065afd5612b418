//! Stacks of films against closed forms, a textbook product of matrices, and the laws of energy and reciprocity.

use super::*;
use crate::fresnel;
use nalgebra::Matrix2;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

const GREEN: f64 = 550e-9;

fn green() -> Wavelength {
    Wavelength::from_metres(GREEN).unwrap()
}

fn index(eta: f64, k: f64) -> Complex64 {
    Complex64::new(eta, -k)
}

fn layer(index: Complex64, wavelengths: f64) -> Layer {
    Layer {
        index,
        thickness: wavelengths * GREEN,
    }
}

fn solve(incident: f64, layers: &[Layer], exit: Complex64, cos_i: f64) -> StackAmplitudes {
    let stack = Stack::new(incident, layers.to_vec(), exit).unwrap();
    stack.amplitudes(cos_i, green())
}

/// `[r_s, r_p, t_s, t_p]`
fn all(a: &StackAmplitudes) -> [Complex64; 4] {
    [
        a.reflected.s,
        a.reflected.p,
        a.transmitted.s,
        a.transmitted.p,
    ]
}

fn distance(a: [Complex64; 4], b: [Complex64; 4]) -> f64 {
    (0..4).map(|i| (a[i] - b[i]).norm()).fold(0.0, f64::max)
}

/// `n cos θ` by Snell's law with angles.
fn normal(n1: f64, n: Complex64, cos_i: f64) -> Complex64 {
    let sin = n1 / n * (1.0 - cos_i * cos_i).sqrt();
    let w = n * (1.0 - sin * sin).sqrt();
    if w.im > 0.0 { -w } else { w }
}

/// Born & Wolf 1.6.2, Eqs. (41), (49), (51), (52), forward product of characteristic matrices; overflows when thick.
fn by_the_book(n1: f64, layers: &[Layer], exit: Complex64, cos_i: f64) -> [Complex64; 4] {
    let k0 = TAU / GREEN;
    let solve = |admittance: &dyn Fn(Complex64) -> Complex64| {
        let mut m = Matrix2::<Complex64>::identity();
        for l in layers {
            let beta = k0 * l.thickness * normal(n1, l.index, cos_i);
            let p = admittance(l.index);
            m *= Matrix2::new(
                beta.cos(),
                I * beta.sin() / p,
                I * p * beta.sin(),
                beta.cos(),
            );
        }
        let (p1, pl) = (admittance(n1.into()), admittance(exit));
        let (u, v) = (m[(0, 0)] + m[(0, 1)] * pl, m[(1, 0)] + m[(1, 1)] * pl);
        ((p1 * u - v) / (p1 * u + v), 2.0 * p1 / (p1 * u + v))
    };
    let (r_s, t_s) = solve(&|n| normal(n1, n, cos_i));
    let (r_p, t_p) = solve(&|n| normal(n1, n, cos_i) / (n * n));
    [r_s, r_p, t_s, t_p * n1 / exit]
}

#[test]
fn a_quarter_wave_layer_of_the_geometric_mean_does_not_reflect() {
    let a = solve(1.0, &[layer(1.5.into(), 0.25 / 1.5)], 2.25.into(), 1.0);
    assert!(a.reflected.s.norm() < 1e-15 && a.reflected.p.norm() < 1e-15);
    // any other index: r = (n₀ n_s − n²)/(n₀ n_s + n²)
    let n: f64 = 1.38;
    let a = solve(1.0, &[layer(n.into(), 0.25 / n)], 1.52.into(), 1.0);
    assert!((a.reflected.s - (1.52 - n * n) / (1.52 + n * n)).norm() < 1e-15);
    assert!((a.reflected.s + a.reflected.p).norm() < 1e-15);
}

#[test]
fn a_quarter_wave_stack_is_a_mirror() {
    let (high, low, glass): (f64, f64, f64) = (2.35, 1.38, 1.52);
    for pairs in [1, 3, 10] {
        let pair = [
            layer(high.into(), 0.25 / high),
            layer(low.into(), 0.25 / low),
        ];
        let a = solve(1.0, &pair.repeat(pairs as usize), glass.into(), 1.0);
        let admittance = glass * (high / low).powi(2 * pairs);
        let expected = (1.0 - admittance) / (1.0 + admittance);
        assert!((a.reflected.s - expected).norm() < 1e-13, "{pairs} pairs");
        assert!((a.transmittance()[0] - (1.0 - expected * expected)).abs() < 1e-13);
    }
}

#[test]
fn a_half_wave_layer_is_invisible() {
    for cos_i in [1.0, 0.8, 0.2] {
        let w = normal(1.0, 2.0.into(), cos_i).re;
        let with = solve(1.0, &[layer(2.0.into(), 0.5 / w)], 1.5.into(), cos_i);
        let bare = solve(1.0, &[], 1.5.into(), cos_i);
        assert!((with.reflected.s - bare.reflected.s).norm() < 2e-15);
        assert!((with.reflected.p - bare.reflected.p).norm() < 2e-15);
        // and transmits with the opposite sign
        assert!((with.transmitted.p + bare.transmitted.p).norm() < 2e-15);
    }
}

#[test]
fn an_absorbing_film_on_metal_obeys_airys_formula() {
    let (film, metal) = (index(1.9, 0.3), index(0.2, 3.4));
    for cos_i in [1.0, 57f64.to_radians().cos(), 0.1] {
        let [w0, w1, w2] = [1.0.into(), film, metal].map(|n| normal(1.0, n, cos_i));
        let e = Complex64::cis(-TAU * 0.4 * w1.re) * (TAU * 0.4 * w1.im).exp();
        let airy = |a: [Complex64; 3]| {
            let (r01, r12) = ((a[0] - a[1]) / (a[0] + a[1]), (a[1] - a[2]) / (a[1] + a[2]));
            let whole = 1.0 + r01 * r12 * e * e;
            let through = (1.0 + r01) * (1.0 + r12) * e;
            ((r01 + r12 * e * e) / whole, through / whole)
        };
        let (r_s, t_s) = airy([w0, w1, w2]);
        let (r_p, t_p) = airy([w0, w1 / film / film, w2 / metal / metal]);
        let found = all(&solve(1.0, &[layer(film, 0.4)], metal, cos_i));
        assert!(distance(found, [r_s, r_p, t_s, t_p / metal]) < 4e-15);
    }
}

#[test]
fn an_air_gap_frustrates_total_reflection() {
    // 1/T = 1 + (w² + q²)² sinh²(k₀ q d)/(2 w q)² for s; tangential impedances over the squared indices for p
    let (n, cos_i) = (1.5f64, 0.5f64);
    let (w, q) = (n * cos_i, (n * n * 0.75 - 1.0).sqrt());
    for gap in [0.01, 0.3, 3.0] {
        let a = solve(n, &[layer(1.0.into(), gap)], n.into(), cos_i);
        let sinh = (TAU * gap * q).sinh();
        for (t, w, q) in [
            (a.transmittance()[0], w, q),
            (a.transmittance()[1], w / (n * n), q),
        ] {
            let expected = 1.0 / (1.0 + ((w * w + q * q) * sinh / (2.0 * w * q)).powi(2));
            assert!((t / expected - 1.0).abs() < 1e-13, "{gap}");
        }
    }
}

#[test]
fn a_layer_at_its_critical_angle_lets_the_field_grow_linearly() {
    // 3-4-5: n₁ = 1.25, cos θ = 0.6, w = 0 in air up to the rounding of 0.6; r = iq/(2 + iq), q = k₀ d n₁ cos θ
    for depth in [0.1, 5.0, 1e4] {
        let a = solve(1.25, &[layer(1.0.into(), depth)], 1.25.into(), 0.6);
        let q = TAU * depth * 0.75;
        let expected = I * q / (2.0 + I * q);
        // the rounding of 0.6 leaves w² = 1e-17, and the phase w k₀ d enters squared
        let tolerance = 4e-15 + 1e-16 * (TAU * depth).powi(2) / (1.0 + q);
        assert!((a.reflected.s - expected).norm() < tolerance, "{depth}");
        assert!((a.reflectance()[0] + a.transmittance()[0] - 1.0).abs() < 1e-14);
        assert!((a.reflectance()[1] + a.transmittance()[1] - 1.0).abs() < 1e-14);
    }
}

#[test]
fn thick_absorbing_layers_are_half_spaces() {
    for k in [1e-2, 1.0, 1e3] {
        for depth in [1e4, 1e9, 1e12] {
            let layers = [layer(index(0.4, k), depth), layer(index(2.0, 0.5), depth)];
            for cos_i in [0.0, 1e-9, 0.3, 1.0] {
                let found = all(&solve(1.5, &layers, 1.0.into(), cos_i));
                let bare = fresnel::amplitudes(1.5.into(), layers[0].index, cos_i).reflected;
                assert!((found[0] - bare.s).norm() < 1e-14 && (found[1] - bare.p).norm() < 1e-14);
                assert!(found[2] == Complex64::ZERO && found[3] == Complex64::ZERO);
            }
        }
    }
}

#[test]
fn a_guided_wave_behind_an_evanescent_layer_is_no_pole() {
    // slab of index 2, thickness of its first even s mode for β = n₁ sin θ = 1.5: w tan(k₀ w d/2) = q
    let beta: f64 = 1.5;
    let (w, q) = ((4.0 - beta * beta).sqrt(), (beta * beta - 1.0).sqrt());
    let slab = layer(2.0.into(), 2.0 * (q / w).atan() / (TAU * w));
    let cos_i = (1.0 - (beta / 3.0).powi(2)).sqrt();
    for gap in [0.2, 2.0, 30.0] {
        let layers = [layer(1.0.into(), gap), slab];
        let total = solve(3.0, &layers, 1.0.into(), cos_i);
        assert!((total.reflectance()[0] - 1.0).abs() < 1e-13, "{gap}");
    }
    // coupled out on both sides alike, the mode shifts and widens by the real and imaginary part of the amplitude
    // (q + iw₃)/(q − iw₃) that the gaps add to it: T = sin² of its phase
    let w3 = 3.0 * cos_i;
    let layers = [layer(1.0.into(), 1.0), slab, layer(1.0.into(), 1.0)];
    let through = solve(3.0, &layers, 3.0.into(), cos_i);
    assert!((through.reflectance()[0] + through.transmittance()[0] - 1.0).abs() < 1e-9);
    let expected = (2.0 * (q / w3).atan()).sin().powi(2);
    assert!((through.transmittance()[0] - expected).abs() < 1e-5);
}

#[test]
fn the_power_weights_of_an_absorbing_exit_medium_close_the_balance() {
    for (eta, k) in [(0.2, 3.4), (1.5, 1.0), (3.0, 0.01)] {
        for cos_i in [1.0, 0.6, 0.05] {
            let a = solve(1.3, &[], index(eta, k), cos_i);
            let (r, t) = (a.reflectance(), a.transmittance());
            assert!((r[0] + t[0] - 1.0).abs() < 1e-14 && (r[1] + t[1] - 1.0).abs() < 1e-14);
            assert_eq!(
                a.transmission_mueller(),
                Err(FilmError::AbsorbingExit { k })
            );
        }
    }
}

#[test]
fn a_quarter_wave_at_45_degrees_in_reflection_turns_diagonal_light_as_its_amplitudes_say() {
    // S3 = −2 Im E_x E_y*: a p field that lags by δ has S3 = −sin δ
    let a = solve(1.0, &[layer(index(1.9, 0.3), 0.4)], index(0.2, 3.4), 0.6);
    let m = a.reflection_mueller().to_matrix();
    let product = a.reflected.s * a.reflected.p.conj();
    assert!((m[(3, 2)] + product.im).abs() < 1e-15);
    assert!((a.reflection().mueller().to_matrix() - m).amax() < 1e-15);
    let t = solve(1.0, &[layer(1.38.into(), 0.2)], 1.5.into(), 0.6);
    let m = t.transmission_mueller().unwrap().to_matrix();
    let [s, p] = t.transmittance();
    assert!((m[(0, 0)] - 0.5 * (s + p)).abs() < 1e-15 && (m[(0, 1)] - 0.5 * (s - p)).abs() < 1e-15);
}

#[test]
fn grazing_light_is_reflected_and_total_reflection_transmits_nothing() {
    let a = solve(1.0, &[layer(1.38.into(), 0.2)], 1.5.into(), 0.0);
    assert!((a.reflected.s + 1.0).norm() < 1e-15 && (a.reflected.p + 1.0).norm() < 1e-15);
    assert_eq!(a.transmittance(), [0.0, 0.0]);
    assert_eq!(a.transmission_mueller().unwrap().to_matrix().amax(), 0.0);
    let a = solve(1.0, &[], 1.0.into(), 0.0);
    assert_eq!(a.reflectance(), [1.0, 1.0]);
    let a = solve(1.5, &[layer(1.3.into(), 0.2)], 1.0.into(), 0.5);
    assert_eq!(a.power_weight, [0.0, 0.0]);
    assert_eq!(a.transmission_mueller().unwrap().to_matrix().amax(), 0.0);
}

#[test]
fn bad_numbers_are_named() {
    let text = |incident, layer, exit| {
        Stack::new(incident, vec![layer], exit)
            .unwrap_err()
            .to_string()
    };
    let good = layer(1.5.into(), 1.0);
    assert_eq!(
        text(1.0, layer(Complex64::new(1.5, 0.1), 1.0), 1.0.into()),
        "layer 0: refractive index eta - ik with eta = 1.5 and k = -0.1, expected eta >= 0, k >= 0 and a modulus \
         between 1e-8 and 1e8"
    );
    assert!(text(0.0, good, 1.0.into()).starts_with("incident medium"));
    assert!(text(f64::NAN, good, 1.0.into()).starts_with("incident medium"));
    assert!(text(1.0, good, Complex64::ZERO).starts_with("exit medium"));
    assert_eq!(
        text(
            1.0,
            Layer {
                index: 1.5.into(),
                thickness: -1e-9
            },
            1.0.into()
        ),
        "layer 0: thickness -0.000000001 m, expected a number between 0 and 1e6"
    );
    let metal = Stack::new(1.0, vec![], index(0.2, 3.0)).unwrap();
    assert_eq!(
        metal.reversed().unwrap_err().to_string(),
        "exit medium: extinction coefficient k = 3, expected 0 where light comes from"
    );
}

fn cosine() -> impl Strategy<Value = f64> {
    prop_oneof![6 => 0.0..=1.0, 1 => 1e-12..1e-6, 1 => 1.0 - 1e-9..=1.0, 1 => Just(1.0), 1 => Just(0.6)]
}

fn lossless() -> impl Strategy<Value = Layer> {
    let n =
        prop_oneof![4 => 0.7..3.0f64, 1 => Just(1.0), 1 => Just(1.5), 1 => 1.5 - 1e-9..1.5 + 1e-9];
    let depth = prop_oneof![4 => 0.0..2.0f64, 1 => Just(0.0), 1 => 0.0..1e-9, 1 => 0.0..1e4];
    (n, depth).prop_map(|(n, depth)| layer(n.into(), depth))
}

fn absorbing() -> impl Strategy<Value = Layer> {
    (0.1..3.0f64, 0.0..2.0f64, 0.0..0.5f64).prop_map(|(eta, k, depth)| layer(index(eta, k), depth))
}

proptest! {
    #[test]
    fn what_a_lossless_stack_does_not_reflect_it_transmits(
        n1 in prop_oneof![Just(1.0), Just(1.25), 0.8..2.0f64], layers in prop::collection::vec(lossless(), 0..6),
        exit in prop_oneof![Just(1.0), Just(1.5), 0.8..2.0f64], cos_i in cosine(),
    ) {
        let a = solve(n1, &layers, exit.into(), cos_i);
        for (r, t) in a.reflectance().into_iter().zip(a.transmittance()) {
            prop_assert!((r + t - 1.0).abs() < 1e-12, "{}", r + t - 1.0);
        }
    }

    #[test]
    fn thin_stacks_are_products_of_characteristic_matrices(
        n1 in 0.8..2.0f64, layers in prop::collection::vec(absorbing(), 0..5), eta in 0.1..3.0f64, k in 0.0..4.0f64,
        cos_i in 0.02..=1.0f64,
    ) {
        let exit = index(eta, k);
        let found = all(&solve(n1, &layers, exit, cos_i));
        let expected = by_the_book(n1, &layers, exit, cos_i);
        // the growing exponentials of the book cost it digits
        let grown: f64 = layers.iter().map(|l| TAU / GREEN * l.thickness * normal(n1, l.index, cos_i).im).sum();
        prop_assume!(grown > -6.0);
        prop_assert!(distance(found, expected) < 1e-14 * (-2.0 * grown).exp().max(10.0));
    }

    #[test]
    fn absorbing_stacks_are_passive_and_reciprocal(
        n1 in 0.8..2.0f64, layers in prop::collection::vec(absorbing(), 0..6), exit in 0.8..2.0f64,
        cos_i in 0.01..=1.0f64,
    ) {
        let stack = Stack::new(n1, layers, exit.into()).unwrap();
        let there = stack.amplitudes(cos_i, green());
        for (r, t) in there.reflectance().into_iter().zip(there.transmittance()) {
            prop_assert!(r + t <= 1.0 + 1e-14);
        }
        let cos_t = fresnel::refract(cos_i, n1, exit.into());
        prop_assume!(cos_t.im == 0.0 && cos_t.re > 0.01);
        // Z Jᵀ Z of the power-weighted matrix is the same matrix; amplitudes carry the ratio n cos θ
        let back = stack.reversed().unwrap().amplitudes(cos_t.re, green());
        let ratio = exit * cos_t.re / (n1 * cos_i);
        let (t, u) = (there.transmitted, back.transmitted);
        prop_assert!((t.s * ratio - u.s).norm() < 1e-12 * (1.0 + ratio));
        prop_assert!((t.p * ratio - u.p).norm() < 1e-12 * (1.0 + ratio));
    }

    #[test]
    fn layers_without_thickness_are_not_there(
        n1 in 0.8..2.0f64, eta in 0.1..3.0f64, k in 0.0..4.0f64, cos_i in cosine(),
        films in prop::collection::vec(absorbing(), 0..5),
    ) {
        let films: Vec<_> = films.into_iter().map(|l| Layer { thickness: 0.0, ..l }).collect();
        let found = solve(n1, &films, index(eta, k), cos_i);
        let bare = fresnel::amplitudes(n1.into(), index(eta, k), cos_i);
        prop_assert!((found.reflected.s - bare.reflected.s).norm() < 1e-14);
        prop_assert!((found.reflected.p - bare.reflected.p).norm() < 1e-14);
        prop_assert!((found.transmitted.s - bare.transmitted.s).norm() < 1e-14);
        prop_assert!((found.transmitted.p - bare.transmitted.p).norm() < 1e-14 * (1.0 + bare.transmitted.p.norm()));
    }
}

#[test]
fn a_phase_plate_of_glass_at_normal_incidence_delays() {
    // index matched but for the plate's phase: t = e^{−iπ/2} behind a quarter wave of equal index
    let a = solve(1.5, &[layer(1.5.into(), 0.25 / 1.5)], 1.5.into(), 1.0);
    assert!((a.transmitted.s - Complex64::cis(-FRAC_PI_2)).norm() < 1e-15);
    assert!((a.transmitted.p - Complex64::cis(-FRAC_PI_2)).norm() < 1e-15);
}
