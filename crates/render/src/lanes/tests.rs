//! Claims: functions are as accurate as they say, and any number of lanes gives the same bits.

use super::*;

/// Numbers from `low` to `high`, evenly apart.
fn grid(low: f64, high: f64) -> impl Iterator<Item = f32> {
    const STEPS: u32 = 200_000;
    (0..=STEPS).map(move |k| (low + (high - low) * f64::from(k) / f64::from(STEPS)) as f32)
}

#[test]
fn exponential_and_logarithm_are_accurate() {
    for x in grid(-86.9, 87.9) {
        let expected = f64::from(x).exp();
        let error = (f64::from(exp(x)) / expected - 1.0).abs();
        assert!(error < 2e-7, "exp({x}): {error}");
    }
    assert_eq!(exp(-1e4f32), 0.0);
    assert_eq!(exp(f32::NEG_INFINITY), 0.0);
    for x in grid(-87.0, 88.0).map(|x| f64::from(x).exp() as f32) {
        let expected = f64::from(x).ln();
        let error = (f64::from(ln(x)) - expected).abs();
        assert!(error < 1e-7 + 2e-7 * expected.abs(), "ln({x}): {error}");
    }
}

#[test]
fn circular_functions_are_accurate() {
    for u in grid(0.0, 1.0) {
        let (sin, cos) = sin_cos_turns(u);
        let (expected_sin, expected_cos) = (std::f64::consts::TAU * f64::from(u)).sin_cos();
        assert!((f64::from(sin) - expected_sin).abs() < 2e-7, "sin {u}");
        assert!((f64::from(cos) - expected_cos).abs() < 2e-7, "cos {u}");
        for size in [1e-20f32, 1.0, 1e15] {
            let (y, x) = (expected_sin as f32 * size, expected_cos as f32 * size);
            let expected = f64::from(y).atan2(f64::from(x));
            let error = (f64::from(atan2(y, x)) - expected).abs();
            assert!(error < 3e-7, "atan2({y}, {x}): {error}");
        }
    }
    assert_eq!(atan2(0.0f32, 0.0), 0.0);
}

/// Everything that lanes can do, on some numbers: its bits.
#[derive(Clone, Copy)]
struct Everything<'a>(&'a [f32]);

impl Task for Everything<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<R: Real>(self) -> Vec<u32> {
        let mut found = vec![];
        for chunk in self.0.chunks_exact(2 * MOST) {
            for first in (0..MOST).step_by(R::LANES) {
                let a = R::from_fn(|lane| chunk[first + lane]);
                let b = R::from_fn(|lane| chunk[MOST + first + lane]);
                let unit = (a * R::splat(0.01)).abs().min(R::one());
                let (sin, cos) = sin_cos_turns(unit);
                let d = R::D::wide(a) * R::D::wide(b) + R::D::wide(a) / R::D::wide(b);
                let v = V3::new(a, b, a * b).normalize();
                let axes = Axes::around(v);
                let hashed = (a.bits() * b.bits() + R::B::splat(12345)) ^ a.bits().shr::<7>();
                let all = [
                    a + b,
                    a - b,
                    a * b,
                    a / b,
                    -a,
                    a.abs().sqrt(),
                    a.min(b),
                    a.max(b),
                    a.round(),
                    a.copysign(b),
                    R::select(a.lt(b), a, b),
                    R::select(a.le(b) & !a.eq(b), b, a),
                    exp(a),
                    ln(b.abs()),
                    sin,
                    cos,
                    atan2(a, b),
                    d.narrow(),
                    (-d).max(d).sqrt().narrow(),
                    a.only(d.is_negative()),
                    axes.s.x,
                    axes.t.z,
                    axes.to_world(axes.to_local(v)).y,
                    R::of_int(hashed.shr::<8>()),
                    R::of_int(a.abs().to_int()),
                ];
                for lane in 0..R::LANES {
                    found.extend(all.iter().map(|r| r.lane(lane).to_bits()));
                }
            }
        }
        found
    }
}

#[test]
fn any_number_of_lanes_gives_the_same_bits() {
    let numbers: Vec<f32> = (0..16_000u64)
        .map(|i| {
            let [u, v] = crate::sampler::SampleStream::new(5, 0, i).pair(0);
            (u - 0.5) * (20.0 * v).exp2() * 1e-3
        })
        .collect();
    let all = run_with_each(Everything(&numbers));
    let one = &all[0];
    assert_eq!(one.len(), 25 * 8_000);
    for most in &all[1..] {
        for (k, (one, most)) in one.iter().zip(most).enumerate() {
            let numbers = [one, most].map(|bits| f32::from_bits(*bits));
            let same = one == most || numbers.iter().all(|x| x.is_nan());
            assert!(same, "operation {} of {}: {one:x} {most:x}", k % 25, k / 25);
        }
    }
}

/// Lanes of every set that come first, and numbers gathered from anywhere.
#[derive(Clone, Copy)]
struct Moves;

impl Task for Moves {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        let numbers: [f32; 100] = std::array::from_fn(|k| k as f32);
        for set in 0..1u32 << R::LANES {
            let mask = R::M::from_bits(set);
            let lanes = R::load(&numbers, 3).ordered(R::order(mask));
            let mut first = 0;
            each(set, |lane| {
                assert_eq!(lanes.lane(first), (3 + lane) as f32, "{set:b}");
                first += 1;
            });
        }
        let places = R::B::from_fn(|lane| lane as u32 * 37 % 110);
        let found = R::gather(&numbers, places);
        let mut kept = [0.0; 100];
        found.store(&mut kept, 100 - R::LANES);
        for lane in 0..R::LANES {
            let expected = (lane * 37 % 110).min(99) as f32;
            assert_eq!(found.lane(lane), expected);
            assert_eq!(kept[100 - R::LANES + lane], expected);
        }
        assert_eq!(R::first(3).bits(), 7 & R::everywhere().bits());
    }
}

#[test]
fn unknown_instructions_are_refused() {
    for (wish, expected) in [
        ("", Allowed::All),
        ("avx2", Allowed::Avx2),
        ("portable", Allowed::Portable),
    ] {
        assert_eq!(Allowed::of(wish.as_ref()), Ok(expected));
    }
    assert_eq!(
        Allowed::of("AVX2".as_ref()),
        Err(
            "BREWSTER_SIMD: unknown instructions 'AVX2', expected 'avx2' or 'portable', or nothing for all"
                .to_owned()
        )
    );
}

#[test]
fn lanes_are_packed_and_gathered() {
    run_with_each(Moves);
}
