use super::*;

/// A spread over a film of `size` whose pixels have had `even` samples alike.
fn spread(size: [u32; 2], even: u64, weights: Option<[f64; 4]>) -> Spread {
    Spread {
        size,
        most: u64::MAX,
        largest_block: 256,
        open_ended: false,
        judged: false,
        weights,
        stage: Stage::Finished,
        even,
    }
}

#[test]
fn shares_are_in_proportion_between_their_bounds() {
    let wanted = [0.0, 0.5, 1.0, 2.0, 4.0];
    let shares = fill(&wanted, 1.0, 4.0);
    assert!(
        (shares.iter().sum::<f64>() - 20.0).abs() < 1e-9,
        "{shares:?}"
    );
    assert!((shares[0] - 1.0).abs() < 1e-9, "{shares:?}");
    // those above the least: 1 + 7.5 a = 20 if 0.5 a > 1
    let factor = 19.0 / 7.5;
    for (share, wanted) in shares.iter().zip(wanted).skip(1) {
        assert!((share - factor * wanted).abs() < 1e-9, "{shares:?}");
    }
}

#[test]
fn one_pixel_does_not_get_all_and_nobody_nothing() {
    let mut wanted = vec![0.0; 1000];
    wanted[7] = 1.0;
    let shares = fill(&wanted, 2.0, 8.0);
    // what the one may not have goes to all alike
    let rest = (8000.0 - 16.0 * 8.0 - 999.0 * 2.0) / 1000.0;
    assert!((shares[7] - 128.0 - rest).abs() < 1e-9, "{}", shares[7]);
    assert!((shares[8] - 2.0 - rest).abs() < 1e-9);
    for nothing in [vec![0.0; 10], vec![f64::INFINITY; 10], vec![f64::NAN; 10]] {
        let shares = fill(&nothing, 2.0, 8.0);
        assert!(shares.iter().all(|s| (s - 8.0).abs() < 1e-9), "{shares:?}");
    }
    assert_eq!(fill(&[1.0, 1e300, 1e-300], 2.0, 2.0), [2.0; 3]);
}

#[test]
fn a_pixel_has_no_say_in_its_own_number() {
    let size = [9, 7];
    let noise: Vec<f64> = (0..63).map(|i| f64::from(i * 37 % 11)).collect();
    let spread = spread(size, 4, None);
    for (x, y) in [(0, 0), (4, 3), (8, 6)] {
        let before = spread.around(&noise, x, y);
        let mut louder = noise.clone();
        louder[(y * 9 + x) as usize] = 1e9;
        assert_eq!(spread.around(&louder, x, y), before);
        // and the neighbours do
        let beside = if x > 0 { x - 1 } else { x + 1 };
        assert!(spread.around(&louder, beside, y) > 1e6);
    }
}

#[test]
fn every_component_counts_by_its_weight() {
    // S0 is noisy on the left, S3, much weaker, on the right
    let variances: Vec<[f64; 4]> = (0..256)
        .map(|i| {
            if i % 16 < 8 {
                [1.0, 0.0, 0.0, 0.0]
            } else {
                [0.0, 0.0, 0.0, 1e-6]
            }
        })
        .collect();
    let of = |weights| {
        let shares = spread([16, 16], 4, weights).shares(&variances, 16);
        assert!((shares.iter().sum::<f64>() / 256.0 - 16.0).abs() < 1e-6);
        // one of the columns that see their own side only
        (shares[16 * 8 + 3], shares[16 * 8 + 12])
    };
    // the columns on either side of the middle see both, and have more
    let (left, right) = of(None);
    assert!((left / right - 1.0).abs() < 1e-6, "{left} {right}");
    let (left, right) = of(Some([1.0, 1.0, 1.0, 1.0]));
    // 4 is the least; the other side has what is left, but for one column and a half of the middle
    assert!((right - 4.0).abs() < 1e-6 && left > 24.0, "{left} {right}");
    let (left, right) = of(Some([0.0, 0.0, 0.0, 1.0]));
    assert!((left - 4.0).abs() < 1e-6 && right > 24.0, "{left} {right}");
}

#[test]
fn a_pixels_own_run_brings_it_to_its_share_on_the_mean() {
    let spread = spread([1, 1], 64, None);
    for (taken, share) in [
        (64, 64.4),
        (64, 65.0),
        (64, 67.0),
        (128, 180.3),
        (64, 5000.0),
    ] {
        let more = share - taken as f64;
        let n = 20_000;
        let mut mean = 0.0;
        for pixel in 0..n {
            let run = spread.own_run(pixel, taken, share);
            let (samples, blocks) = (run.end - run.first, (run.end - run.first) / run.block);
            assert_eq!((run.first, samples % run.block), (taken, 0));
            // two blocks at least, or the variance is unknown; enough of them where there is room
            assert!(blocks != 1 && (more < 8.0 || blocks >= 8), "{run:?}");
            assert!(blocks <= 17 || run.block == 256, "{run:?}");
            mean += samples as f64 / n as f64;
        }
        // rounding moves a run by less than a block or two samples: 5 standard errors of that
        let block = spread.own_run(0, taken, share).block as f64;
        assert!(
            (mean - more).abs() < 5.0 * block.max(2.0) / (n as f64).sqrt(),
            "{mean} {more}"
        );
    }
    assert_eq!(spread.own_run(0, 100, 50.0).end, 100);
}

#[test]
fn steps_of_a_run_end_with_blocks_and_reach_its_end() {
    let run = Goal {
        first: 12,
        block: 4,
        end: 12 + 4 * 11,
    };
    let ends: Vec<u64> = (1..=8).map(|step| run.cut(step, 8).end).collect();
    assert_eq!(ends, [16, 20, 28, 32, 36, 44, 48, 56]);
}

/// Mean over an image of rare bright samples, in units of the truth, and its standard error, over many seeds. Of each
/// pixel 16 samples say how many there shall be; `own`: of itself, otherwise of its neighbours.
fn mean_of_rare_light(own: bool) -> (f64, f64) {
    const P: f32 = 0.02;
    let size = [12, 12];
    let (mut sum, mut squares) = (0.0, 0.0);
    let seeds = 400;
    for seed in 0..seeds {
        let light = |pixel: u64, sample: u64| {
            let [u, _] = SampleStream::new(seed, pixel, sample).pair(0);
            f64::from(u8::from(u < P))
        };
        let variances: Vec<[f64; 4]> = (0..144)
            .map(|pixel| {
                let mean = (0..16).map(|s| light(pixel, s)).sum::<f64>() / 16.0;
                [mean * (1.0 - mean) * 16.0 / 15.0, 0.0, 0.0, 0.0]
            })
            .collect();
        let spread = spread(size, 16, None);
        let shares = if own {
            let wanted: Vec<f64> = variances.iter().map(|v| v[0].sqrt()).collect();
            fill(&wanted, 16.0, 64.0)
        } else {
            spread.shares(&variances, 64)
        };
        let image = (0..)
            .zip(shares)
            .map(|(pixel, share)| {
                let n = spread.own_run(pixel, 16, share).end;
                (0..n).map(|s| light(pixel, s)).sum::<f64>() / n as f64
            })
            .sum::<f64>()
            / 144.0;
        sum += image;
        squares += image * image;
    }
    let n = seeds as f64;
    let mean = sum / n;
    let error = ((squares / n - mean * mean) / (n - 1.0)).sqrt();
    (mean / f64::from(P), error / f64::from(P))
}

#[test]
fn light_of_rare_paths_is_neither_lost_nor_won() {
    let (mean, error) = mean_of_rare_light(false);
    // 144 pixels of 64 samples and 400 seeds: √((1 − p)/(p · 3.7e6)) if they were spread evenly
    assert!(error < 0.008, "{error}");
    assert!((mean - 1.0).abs() < 4.0 * error, "{mean} {error}");
    // the test would see it: pixels that choose for themselves lose light
    let (mean, error) = mean_of_rare_light(true);
    assert!(mean < 1.0 - 8.0 * error, "{mean} {error}");
}

#[test]
fn rounds_keep_to_the_mean_and_to_their_order() {
    // a film whose pixels differ: every second column is noisy
    let film = crate::film::FilmGeometry {
        size: [8, 8],
        crop_offset: [0, 0],
        crop_size: [8, 8],
        filter: crate::filter::Filter::Box,
        products: false,
    };
    for (most, open_ended) in [(64, false), (100, false), (1000, true), (8, false)] {
        let mut tiles = film.tiles(1, false);
        let mut spread = Spread {
            most,
            open_ended,
            judged: open_ended,
            stage: Stage::Begin,
            even: 0,
            ..spread([8, 8], 0, None)
        };
        let mut goals = 0;
        while let Some(goal) = spread.next(&tiles) {
            goals += 1;
            for (x, y) in tiles[0].pixels() {
                let (taken, goal) = (tiles[0].taken(x, y), goal.of(x, y));
                assert!(goal.first <= taken && goal.block.is_power_of_two());
                if goal.end <= taken {
                    continue;
                }
                tiles[0].go_on(x, y, goal.first, goal.block);
                let mut sums = crate::film::SampleSums::new(1);
                tiles[0].open(x, y, &mut sums);
                for sample in taken..goal.end {
                    let [u, _] = SampleStream::new(5, u64::from(x + 8 * y), sample).pair(0);
                    let light = if x % 2 == 0 { u } else { 0.5 };
                    assert!(sums.add(&[glam::Vec4::splat(light)]));
                    if (sample + 1 - goal.first).is_multiple_of(goal.block) {
                        tiles[0].close(x, y, &mut sums);
                    }
                }
                tiles[0].keep(x, y, &sums, goal.end);
            }
        }
        let all: Vec<u64> = tiles[0]
            .pixels()
            .map(|(x, y)| tiles[0].taken(x, y))
            .collect();
        let mean = all.iter().sum::<u64>() as f64 / 64.0;
        // rounding of 64 pixels to blocks of an eighth of their samples
        assert!((mean / most as f64 - 1.0).abs() < 0.1, "{most}: {mean}");
        assert!(all.iter().all(|n| *n >= most / 8), "{all:?}");
        assert!(
            tiles[0]
                .pixels()
                .all(|(x, y)| tiles[0].pixel(x, y).blocks() >= 4)
        );
        assert!(goals >= if open_ended { 20 } else { 2 }, "{most}: {goals}");
    }
}
