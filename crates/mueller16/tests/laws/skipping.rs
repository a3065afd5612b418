//! What is absent changes nothing of what is there; and light that goes back.

use mueller16::{
    Autocorrelation, ChannelSet, Channels, Energy, GaussianTerm, Geometry, IncidentCoherence,
    Matter, Population,
};
use nalgebra::{Matrix2, Matrix4, Vector2};
use proptest::prelude::*;
use stokes::{Components, Envelope, HermiteSeries, ModeWidth, Mueller};

use crate::tools::{
    blazed, dense, dense_channels, direction, green, light, lopsided, oblique, outgoing_frame,
    series, skew_root,
};

const SETS: [ChannelSet; 5] = [
    ChannelSet::INTENSITY,
    ChannelSet::DIAGONAL,
    ChannelSet::BLOCKS,
    ChannelSet::ALL,
    ChannelSet::EMPTY,
];

/// The dense matrix with 0 where the set has no channel.
fn masked(set: ChannelSet) -> Mueller {
    let m = dense();
    Matrix4::from_fn(|l, j| {
        if set.contains(j, l) {
            m.element(l, j)
        } else {
            0.0
        }
    })
    .into()
}

fn coherence(order: usize) -> IncidentCoherence {
    IncidentCoherence::new(skew_root() * 1e7, &series(order, 0.4)).unwrap()
}

/// Sixteen channels with an autocorrelation each: the transfer of all of them has, channel by channel, the bits of the
/// transfer of one, wherever it stands in the list and whatever its neighbours are.
#[test]
fn channels_of_different_autocorrelations_do_not_touch_each_other() {
    let geometry = oblique([5e4, -3e4]);
    let places: Vec<_> = (0..16).map(|i| (i / 4, i % 4)).collect();
    // single Gaussians, but for two of every five
    let matter = |i: usize| {
        let root = skew_root() * (1e-3 * (1.0 + 0.1 * i as f64));
        let terms = (0..1 + usize::from(i % 5 > 2)).map(|t| GaussianTerm {
            weight: 0.7 - 0.1 * t as f64,
            rate: 1.0 + t as f64,
            shift: Vector2::new(2e4 * i as f64, -1e4 * t as f64),
        });
        Autocorrelation::of_family(&root, terms).unwrap()
    };
    let (l, j) = places[7];
    assert!(matter(7).spectrum(&geometry.tangential()) > 0.0);
    let one = |(l, j): (usize, usize)| -> Mueller {
        let mut m = Matrix4::zeros();
        m[(l, j)] = 0.3 + l as f64 - 0.2 * j as f64;
        m.into()
    };
    for order in [0, 4] {
        let light =
            IncidentCoherence::new(Matrix2::new(7e4, -5e4, 2e4, 9e4), &series(order, 0.4)).unwrap();
        for count in [4, 5, 7, 16] {
            let all = (0..count).fold(Channels::default(), |sum, i| {
                sum.with(&one(places[i]), matter(i), 0)
            });
            let together = all.transfer(&geometry, &light).unwrap().total();
            for (i, &(l, j)) in places.iter().enumerate().take(count) {
                let alone = Channels::new(&one((l, j)), matter(i));
                let alone = alone.transfer(&geometry, &light).unwrap().total();
                assert_eq!(
                    together.element(l, j),
                    alone.element(l, j),
                    "{order} {count} {i}"
                );
            }
        }
        assert_ne!(0.0, {
            let alone = Channels::new(&one((l, j)), matter(7));
            alone
                .transfer(&geometry, &light)
                .unwrap()
                .total()
                .element(l, j)
        });
    }
}

#[test]
fn every_channel_set_gives_the_same_bits_on_the_channels_it_has() {
    let geometry = oblique([5e4, -3e4]);
    for components in [
        lopsided(),
        Components::Shared {
            modes: series(4, 0.7),
            stokes: [1.0, 0.3, -0.2, 0.5].into(),
        },
        Components::Shared {
            modes: series(0, 0.7),
            stokes: [1.0, 0.3, -0.2, 0.5].into(),
        },
    ] {
        let light = light(&geometry, components);
        let all = dense_channels();
        let whole = all.amplitudes(&geometry, &light).unwrap();
        let matrix = all.transfer(&geometry, &coherence(4)).unwrap().total();
        for set in SETS {
            let some = Channels::new(&masked(set), blazed());
            assert_eq!(some.set(), set);
            let found = some.amplitudes(&geometry, &light).unwrap();
            let transfer = some.transfer(&geometry, &coherence(4)).unwrap().total();
            for j in 0..4 {
                for l in 0..4 {
                    let (expected, element) = if set.contains(j, l) {
                        (whole.channel(j, l, 0), matrix.element(l, j))
                    } else {
                        (0.0, 0.0)
                    };
                    assert_eq!(found.channel(j, l, 0), expected, "{set} {j} → {l}");
                    assert_eq!(transfer.element(l, j), element, "{set} {j} → {l}");
                }
            }
        }
    }
}

#[test]
fn an_absent_component_or_mode_leaves_the_other_bits() {
    let geometry = oblique([5e4, -3e4]);
    let channels = dense_channels();
    let Components::Separate(all) = lopsided() else {
        panic!("separate")
    };
    let whole = channels
        .amplitudes(&geometry, &light(&geometry, lopsided()))
        .unwrap();
    for out in 0..16 {
        let here = |j: usize| out >> j & 1 == 0;
        let some = std::array::from_fn(|j| all[j].clone().filter(|_| here(j)));
        let light = light(&geometry, Components::Separate(some));
        let found = channels.amplitudes(&geometry, &light).unwrap();
        for j in 0..4 {
            for l in 0..4 {
                let expected = if here(j) { whole.channel(j, l, 0) } else { 0.0 };
                assert_eq!(found.channel(j, l, 0), expected);
            }
        }
    }
    // modes of 0 above the last: the same sum, in a buffer of another size
    let short = series(3, 0.2);
    for order in [4, 7, 20, 70] {
        let mut real = short.real_coefficients().to_vec();
        real.resize(stokes::mode_count(order), 0.0);
        let long = HermiteSeries::from_real_coefficients(&real).unwrap();
        let of = |modes: &HermiteSeries| {
            let light = IncidentCoherence::new(skew_root() * 1e7, modes).unwrap();
            channels
                .transfer(&geometry, &light)
                .unwrap()
                .total()
                .to_matrix()
        };
        let (a, b) = (of(&short), of(&long));
        // the sum at 0 and that of the modes may be added in another order: ten numbers, each rounded a few times
        assert!((a - b).amax() <= 64.0 * f64::EPSILON * a.amax(), "{order}");
    }
}

#[test]
fn a_population_over_another_envelope_does_not_touch_the_first() {
    let geometry = oblique([5e4, -3e4]);
    let envelope =
        |size: f64| Envelope::gaussian(&Matrix2::from_diagonal_element(size * size)).unwrap();
    let first = || Population::of_sixteen(&dense(), blazed(), envelope(1e-4));
    let wide = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-11)).unwrap();
    let second = Population::of_sixteen(&Mueller::identity(), wide.clone(), envelope(2e-4));
    let light = light(&geometry, lopsided());
    let scattered = |populations: Vec<Population>| {
        let matter = Matter::new(populations).unwrap();
        let modes = matter.modes(ModeWidth::VarianceMatched, 0).unwrap();
        let frame = outgoing_frame(&geometry);
        matter
            .scatter(&modes, &geometry, &light, Energy::Conserving, frame, 1.0)
            .unwrap()
    };
    let (one, two) = (scattered(vec![first()]), scattered(vec![first(), second]));
    assert_eq!((one.len(), two.len()), (1, 2));
    assert_eq!(one[0], two[0]);
    // in the same envelope it is added, and taking it away leaves rounding
    let more = Channels::new(&dense(), blazed()).with(&Mueller::identity(), wide.clone(), 0);
    let less = more
        .clone()
        .with(&(Matrix4::identity() * -1.0).into(), wide, 0);
    let bits = |channels: &Channels| {
        channels
            .transfer(&geometry, &coherence(4))
            .unwrap()
            .total()
            .to_matrix()
    };
    assert_eq!(bits(&less), bits(&Channels::new(&dense(), blazed())));
    assert!((bits(&more) - bits(&less)).amax() > 0.0);
}

proptest! {
    #[test]
    fn the_lobe_is_the_same_for_light_that_goes_back(
        i in prop::array::uniform2(0.0..1.0f64), o in prop::array::uniform2(0.0..1.0f64), n in 1.0..2.0f64,
        below in any::<bool>(),
    ) {
        let there = |u: [f64; 2]| direction(89.0 * u[0], 360.0 * u[1]);
        let mut to_observer = there(o);
        if below {
            to_observer.z = -to_observer.z;
        }
        let media = if below { [1.0, n] } else { [n, n] };
        let geometry = Geometry::on_plane(there(i), to_observer, green()).unwrap();
        let geometry = geometry.between(media[0], media[1]).unwrap();
        let back = geometry.reversed();
        prop_assert_eq!(geometry.tangential(), back.tangential());
        let f = |channels: &Channels, geometry: &Geometry| {
            let t = channels.transfer(geometry, &IncidentCoherence::plane_wave()).unwrap();
            let factor = Energy::HeightSurface.factor(geometry).unwrap();
            t.total().to_matrix() * (factor / geometry.n_outgoing().powi(2))
        };
        // lobes of some 1e7 rad/m about two places, which every pair of directions sees
        let term = |weight, x: f64, y: f64| GaussianTerm { weight, rate: 1.0, shift: Vector2::new(x, y) };
        let terms = [term(0.7, 0.0, 0.0), term(0.3, 5e6, -3e6)];
        let r = Autocorrelation::of_family(&crate::tools::root_of_size(0.1), terms).unwrap();
        // f(o → i) = X f(i → o)ᵀ X: the matter of the way back is reversed, R is not
        let forth = f(&Channels::new(&dense(), r.clone()), &geometry);
        let reversed = f(&Channels::new(&dense().reversed(), r), &back);
        let expected = Mueller::from(forth).reversed().to_matrix();
        // n² and the obliquity are multiplied in another order
        prop_assert!(expected.amax() > 0.0);
        prop_assert!((reversed - expected).amax() <= 16.0 * f64::EPSILON * expected.amax());
    }
}
