//! Claim: the compact algebra of paths is the product of Mueller matrices with every frame turned explicitly.
//!
//! Random chains of random matter in random frames against full 4×4 products in double precision.

use std::array::from_fn;

use glam::{DMat4, DVec3, DVec4, Mat4, Vec3, Vec3A, Vec4};

use super::{Element, Emission, Light, MuellerResponse, MuellerThroughput, Polarized};
use crate::geometry::frame::Frame;
use crate::sampler::SampleStream;

type P = Polarized<2>;

/// Uniform numbers in [−1, 1).
struct Dice {
    stream: SampleStream,
    next: u32,
}

impl Dice {
    fn throw(&mut self) -> f32 {
        self.next += 2;
        2.0 * self.stream.pair(self.next)[0] - 1.0
    }

    fn direction(&mut self) -> Vec3A {
        loop {
            let v = Vec3A::new(self.throw(), self.throw(), self.throw());
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// A random axis across a direction.
    fn across(&mut self, k: Vec3A) -> Vec3A {
        Frame::with_tangent(k, self.direction()).s
    }

    fn matrix(&mut self) -> Mat4 {
        Mat4::from_cols_array(&from_fn(|_| self.throw()))
    }
}

/// Takes Stokes vectors from the frame of `from` to that of `to`, both across `k`.
///
/// Source: Goldstein, Polarized Light, 3rd ed., Eq. (6.44): turned by θ, S1' = S1 cos 2θ + S2 sin 2θ.
fn turn(from: Vec3A, to: Vec3A, k: Vec3A) -> DMat4 {
    let [from, to, k]: [DVec3; 3] = [from, to, k].map(Vec3A::as_dvec3);
    let theta = k.cross(from).dot(to).atan2(from.dot(to));
    let (s, c) = (2.0 * theta).sin_cos();
    DMat4::from_cols(
        DVec4::X,
        DVec4::new(0.0, c, -s, 0.0),
        DVec4::new(0.0, s, c, 0.0),
        DVec4::W,
    )
}

fn reference(k: Vec3A) -> Vec3A {
    Frame::around(k).s
}

/// A response, and its matrices between the reference frames of its two directions.
type Both = (MuellerResponse<2>, [DMat4; 2]);

fn response(dice: &mut Dice, k_out: Vec3A, k_in: Vec3A, kind: u32) -> Both {
    let (response, axis_out, axis_in, plain): (_, _, _, [Mat4; 2]) = match kind {
        0 => {
            let values = [dice.throw(), dice.throw()];
            let depolarizer =
                |i: usize| Mat4::from_cols(Vec4::X * values[i], Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
            let response = P::depolarizing(|i| values[i]);
            (
                response,
                reference(k_out),
                reference(k_in),
                from_fn(depolarizer),
            )
        }
        1 => {
            let axis = k_out.cross(k_in).normalize();
            let elements: [Element; 2] = from_fn(|_| Element {
                mean: dice.throw(),
                difference: dice.throw(),
                cosine: dice.throw(),
                sine: dice.throw(),
            });
            let response = P::diattenuating_retarder(axis, |i| elements[i]);
            (response, axis, axis, elements.map(Element::matrix))
        }
        _ => {
            let axes = (dice.across(k_out), dice.across(k_in));
            let matrices: [Mat4; 2] = from_fn(|_| dice.matrix());
            (
                P::general(axes.0, axes.1, |i| matrices[i]),
                axes.0,
                axes.1,
                matrices,
            )
        }
    };
    let expected = plain.map(|m| {
        turn(axis_out, reference(k_out), k_out)
            * m.as_dmat4()
            * turn(reference(k_in), axis_in, k_in)
    });
    (response, expected)
}

/// A source, and its Stokes vectors in the reference frame of its light.
fn source(dice: &mut Dice, k: Vec3A, polarized: bool) -> (Emission<P>, [DVec4; 2]) {
    let radiance = [dice.throw(), dice.throw()];
    if !polarized {
        let plain = radiance.map(|r| DVec4::X * f64::from(r));
        return (Emission::unpolarized(|i| radiance[i]), plain);
    }
    let axis = dice.across(k);
    let states: [Vec3; 2] = from_fn(|_| Vec3::new(dice.throw(), dice.throw(), dice.throw()));
    let stokes = from_fn(|i| {
        let s = states[i].as_dvec3();
        turn(axis, reference(k), k) * (DVec4::new(1.0, s.x, s.y, s.z) * f64::from(radiance[i]))
    });
    (
        Emission::polarized(|i| radiance[i], axis, |i| states[i]),
        stokes,
    )
}

fn assert_close(what: &str, found: [Vec4; 2], expected: [DVec4; 2], scale: f64) {
    for (found, expected) in found.iter().zip(expected) {
        // a dozen products of single precision, each of four terms
        assert!(
            (found.as_dvec4() - expected).abs().max_element() < 1e-5 * scale,
            "{what}: {found} for {expected}"
        );
    }
}

#[test]
fn paths_are_products_of_mueller_matrices() {
    const LENGTH: usize = 4;
    for case in 0..2000 {
        let dice = &mut Dice {
            stream: SampleStream::new(11, 0, case),
            next: 0,
        };
        let k: [Vec3A; LENGTH + 1] = from_fn(|_| dice.direction());
        let first = dice.across(k[0]);
        let kinds: [u32; LENGTH] = from_fn(|_| (1.5 * (dice.throw() + 1.0)) as u32);
        let chain: [Both; LENGTH] = from_fn(|i| response(dice, k[i], k[i + 1], kinds[i]));
        let (light, stokes) = source(dice, k[LENGTH], case % 3 > 0);
        let expected: [DVec4; 2] = from_fn(|lane| {
            let seen = chain
                .iter()
                .rev()
                .fold(stokes[lane], |s, (_, m)| m[lane] * s);
            turn(reference(k[0]), first, k[0]) * seen
        });
        // matrices with 16 elements up to one
        let scale = 4f64.powi(LENGTH as i32);

        let all = (0..LENGTH).fold(P::identity(first), |t, i| {
            P::extend(&t, chain[i].0, 0.5, k[i])
        });
        let found = P::collect(&all, &light, k[LENGTH]);
        assert_close("collect", found.map(|s| s * 16.0), expected, scale);

        let most = (0..LENGTH - 1).fold(P::identity(first), |t, i| {
            P::extend(&t, chain[i].0, 1.0, k[i])
        });
        let last = LENGTH - 1;
        let found = P::collect_through(&most, chain[last].0, k[last], &light, k[LENGTH]);
        assert_close("collect_through", found, expected, scale);

        // the middle as one response
        let axis = dice.across(k[1]);
        let middle = (1..LENGTH).fold(P::identity(axis), |t, i| {
            P::extend(&t, chain[i].0, 1.0, k[i])
        });
        let start = P::extend(&P::identity(first), chain[0].0, 1.0, k[0]);
        let joined = P::extend(&start, P::as_response(&middle, axis), 1.0, k[1]);
        assert_close(
            "as_response",
            P::collect(&joined, &light, k[LENGTH]),
            expected,
            scale,
        );
        let found = P::collect_through(
            &start,
            P::as_response(&middle, axis),
            k[1],
            &light,
            k[LENGTH],
        );
        assert_close("as_response, collected through", found, expected, scale);
    }
}

#[test]
fn sums_of_responses_add_what_they_do() {
    for case in 0..900 {
        let dice = &mut Dice {
            stream: SampleStream::new(12, 0, case),
            next: 0,
        };
        let (k_out, k_in) = (dice.direction(), dice.direction());
        let first = dice.across(k_out);
        let a = response(dice, k_out, k_in, case as u32 % 3);
        let b = response(dice, k_out, k_in, case as u32 / 3 % 3);
        let (light, stokes) = source(dice, k_in, case % 2 > 0);
        let expected: [DVec4; 2] = from_fn(|lane| {
            turn(reference(k_out), first, k_out) * ((a.1[lane] + b.1[lane]) * stokes[lane])
        });
        let both = P::sum(a.0, b.0, k_out, k_in);
        let path = P::extend(&P::identity(first), both, 1.0, k_out);
        assert_close("sum", P::collect(&path, &light, k_in), expected, 4.0);
    }
}

/// A retarder, perhaps with some diattenuation, as matter has them: its own axes are those of the plane of incidence.
fn link(dice: &mut Dice, k: [Vec3A; 2], difference: f32) -> Both {
    let axis = k[0].cross(k[1]).normalize();
    let element = {
        let angle = f64::from(dice.throw()) * std::f64::consts::PI;
        // what is not split between the two states is split between phase and quadrature
        let root = (1.0 - f64::from(difference).powi(2)).sqrt();
        Element {
            mean: 1.0,
            difference,
            cosine: (root * angle.cos()) as f32,
            sine: (root * angle.sin()) as f32,
        }
    };
    let expected = turn(axis, reference(k[0]), k[0])
        * element.matrix().as_dmat4()
        * turn(reference(k[1]), axis, k[1]);
    (P::diattenuating_retarder(axis, |_| element), [expected; 2])
}

#[test]
fn a_thousand_links_drift_as_rounding_adds_up() {
    // lossless links in single precision against the same links in double: each rounds its axis, its double angle, the
    // turn and the product, a dozen units of rounding at most, and 1000 of them add up at worst
    const LINKS: usize = 1000;
    const ROUNDING: f64 = 5.960_464_477_539_063e-8;
    let mut worst = 0.0f64;
    for case in 0..40 {
        let dice = &mut Dice {
            stream: SampleStream::new(12, 0, case),
            next: 0,
        };
        let mut k = dice.direction();
        let first = dice.across(k);
        let mut found = P::identity(first);
        let mut expected = turn(reference(k), first, k);
        for _ in 0..LINKS {
            let next = dice.direction();
            let (response, matrices) = link(dice, [k, next], 0.0);
            found = P::extend(&found, response, 1.0, k);
            expected *= matrices[0];
            k = next;
        }
        let light = Emission::polarized(|_| 1.0, reference(k), |_| Vec3::new(0.6, 0.0, 0.8));
        let found = P::collect(&found, &light, k)[0].as_dvec4();
        let expected = expected * DVec4::new(1.0, f64::from(0.6f32), 0.0, f64::from(0.8f32));
        assert!(found.is_finite());
        let drift = (found - expected).abs().max_element();
        worst = worst.max(drift);
        // S0 has no turns, only products with one
        assert!((found.x - 1.0).abs() <= LINKS as f64 * ROUNDING, "{found}");
    }
    assert!(worst < 12.0 * LINKS as f64 * ROUNDING, "{worst:e}");
    // and it is no accident of identical arithmetic: single precision does round
    assert!(worst > ROUNDING, "{worst:e}");
    println!(
        "1000 links: {:.2} units of rounding a link",
        worst / (LINKS as f64 * ROUNDING)
    );
}

#[test]
fn the_reach_of_a_path_is_what_the_best_light_makes() {
    for case in 0..200 {
        let dice = &mut Dice {
            stream: SampleStream::new(13, 0, case),
            next: 0,
        };
        let k: [Vec3A; 4] = from_fn(|_| dice.direction());
        let first = dice.across(k[0]);
        let mut path = P::identity(first);
        for i in 0..3 {
            let difference = 0.9 * dice.throw();
            let (response, _) = link(dice, [k[i], k[i + 1]], difference);
            path = P::extend(&path, response, 0.7, k[i]);
            if i == 0 && case % 3 == 0 {
                let depolarizing = P::depolarizing(|lane| 0.5 + 0.25 * lane as f32);
                path = P::extend(&path, depolarizing, 1.0, k[i + 1]);
            }
        }
        let axis = match path {
            MuellerThroughput::Full { axis, .. } | MuellerThroughput::RankOne { axis, .. } => axis,
            MuellerThroughput::Intensity { .. } => first,
        };
        let reach = P::reach(&path);
        // over the sphere of states, densely
        let mut most = 0.0f32;
        for _ in 0..4000 {
            let state = Vec3::from(dice.direction());
            let light = Emission::polarized(|_| 1.0, axis, |_| state);
            let seen = P::collect(&path, &light, k[3]);
            for stokes in seen {
                most = most.max(stokes.x);
                // no component beyond S0, but for a dozen roundings a link
                let others = Vec3::new(stokes.y, stokes.z, stokes.w).length();
                assert!(others <= stokes.x + 36.0 * 6e-8 * reach, "{stokes} {reach}");
            }
        }
        // 4000 directions miss the best by an angle of √(4 ln 4000/4000) at most, all but surely: 1 − cos of it
        assert!(
            most <= reach * (1.0 + 1e-5) && most > reach * 0.99,
            "{most} {reach}"
        );
        assert!(reach <= 2.0 * P::strength(&path) * (1.0 + 1e-5));
    }
}
