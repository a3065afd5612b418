//! Tests of the comparison: numbers of an independent NumPy script on arrays that both sides can form exactly.

use super::*;

/// Numbers by formula: test, reference, their standard errors; 6 rows, 7 columns.
fn specimen(colours: usize) -> [Field; 4] {
    let field = |f: &dyn Fn(usize) -> f64| Field {
        width: 7,
        height: 6,
        components: 4,
        colours,
        values: (0..6 * 7 * 4 * colours).map(f).collect(),
    };
    let reference = |i: usize| ((i * 37 % 101) as f64 - 20.0) / 64.0;
    [
        field(&|i| reference(i) + ((i * 53 % 89) as f64 - 43.0) / 1024.0),
        field(&reference),
        field(&|i| ((i * 17 % 23) as f64 + 1.0) / 1024.0),
        field(&|i| ((i * 29 % 31) as f64 + 1.0) / 2048.0),
    ]
}

/// rmse, excess, mean, t, z>4, z rms, greatest z, block>5, max.
type Numbers = [f64; 9];

fn assert_rows(rows: &[Row], expected: &[Numbers; 4]) {
    for (row, expected) in rows.iter().zip(expected) {
        let found = [
            row.rmse,
            row.excess_rmse.unwrap(),
            row.mean,
            row.mean_t,
            row.z4_frac.unwrap(),
            row.z_rms.unwrap(),
            row.z_max.unwrap(),
            row.block5_frac,
            row.max_abs,
        ];
        for (f, e) in found.iter().zip(expected) {
            // sums in another order: a few units in the last place of double precision
            assert!(
                (f - e).abs() <= 1e-12 * e.abs(),
                "{}: {found:?}, expected {expected:?}",
                row.component
            );
        }
    }
}

const SETTINGS: Settings = Settings {
    block: 3,
    floor: 1e-6,
};

#[test]
fn one_colour_agrees_with_numpy() {
    let [t, r, st, sr] = specimen(1);
    let (rows, scale) = compare(&t, &r, Some(&st), Some(&sr), &SETTINGS).unwrap();
    assert!((scale - 0.5316220238095238).abs() < 1e-15);
    let expected = [
        [
            0.025217436760944296,
            0.01890970065751497,
            0.0013020833333333333,
            0.3350751256189842,
            0.09523809523809523,
            6.610281561261791,
            38.46035771866743,
            0.0,
            0.0439453125,
        ],
        [
            0.02510870053862924,
            0.019701407228351578,
            0.0013253348214285715,
            0.34255622135620495,
            0.07142857142857142,
            2.4944158430489836,
            8.45043390510691,
            0.0,
            0.04296875,
        ],
        [
            0.02512813609455165,
            0.019347864887909367,
            0.0013485863095238095,
            0.34831282259347607,
            0.11904761904761904,
            3.1193464371698543,
            12.074765562809814,
            0.0,
            0.04296875,
        ],
        [
            0.025034435715595972,
            0.018997305313273684,
            0.0013718377976190475,
            0.35566623281767856,
            0.047619047619047616,
            2.721707679487633,
            12.64910997700235,
            0.0,
            0.0439453125,
        ],
    ];
    assert_rows(&rows, &expected);
}

#[test]
fn three_colours_agree_with_numpy() {
    let [t, r, st, sr] = specimen(3);
    let (rows, scale) = compare(&t, &r, Some(&st), Some(&sr), &SETTINGS).unwrap();
    assert!((scale - 0.5313740079365079).abs() < 1e-15);
    let expected = [
        [
            0.02521728668886571,
            0.01934326776664022,
            0.000999813988095238,
            0.25715034383564245,
            0.0873015873015873,
            4.331052154146151,
            38.46035772542085,
            0.3333333333333333,
            0.0439453125,
        ],
        [
            0.02520392669509921,
            0.019286349026541066,
            0.0010695684523809525,
            0.2752684408703707,
            0.06349206349206349,
            2.9104913751112984,
            17.947630063124713,
            0.08333333333333333,
            0.0439453125,
        ],
        [
            0.025031714531974218,
            0.019110665261935375,
            0.0011393229166666667,
            0.29527806917530625,
            0.07936507936507936,
            2.8941295298958023,
            14.976901035551121,
            0.25,
            0.0439453125,
        ],
        [
            0.025103123222393327,
            0.019365167657301983,
            0.001209077380952381,
            0.3125038021456467,
            0.0873015873015873,
            2.434343491989398,
            8.45043390521728,
            0.16666666666666666,
            0.0439453125,
        ],
    ];
    assert_rows(&rows, &expected);
}

#[test]
fn few_blocks_of_samples_lean_on_the_neighbourhood() {
    use crate::image::{BLOCKS, Colour};
    let colour = Colour::Mono {
        wavelength_nm: None,
    };
    let mut image = StokesImage::new(3, 3, 1, colour);
    // one pixel of nine seems noisy
    let mut variance = vec![1.0; 9];
    variance[4] = 10.0;
    image.variance = Some(variance);
    let errors = |image: &StokesImage| Field::standard_errors(image).unwrap().values;
    assert_eq!(errors(&image)[0], 1.0);
    for (blocks, corner) in [(16u64, 1.0), (8, 1.36f64.sqrt())] {
        image.metadata.insert(BLOCKS.to_owned(), blocks.to_string());
        assert_eq!(image.blocks(), Some(blocks));
        // around a corner of 3 × 3 the rim counts again: the middle once among 25
        let found = errors(&image);
        assert!((found[0] - corner).abs() < 1e-12, "{found:?}");
        assert_eq!(found[4], 10f64.sqrt());
    }
}

#[test]
fn the_mean_of_seeds_agrees_with_numpy() {
    let [t, r, _, sr] = specimen(1);
    let shifted = |f: &dyn Fn(usize) -> f64| {
        t.map(t.values.iter().enumerate().map(|(i, v)| v + f(i)).collect())
    };
    let renders = [
        t.clone(),
        shifted(&|i| ((i * 7 % 13) as f64 - 6.0) / 256.0),
        shifted(&|i| -((i * 11 % 17) as f64 - 8.0) / 512.0),
    ];
    let (mean, error) = mean_of_seeds(&renders);
    let (rows, _) = compare(&mean, &r, Some(&error), Some(&sr), &SETTINGS).unwrap();
    let expected = [
        [
            0.025097494403841167,
            0.022422056451790472,
            0.0010075644841269845,
            0.2603858528894747,
            0.14285714285714285,
            2.7289772379356916,
            6.798784932844906,
            0.0,
            0.04524739583333326,
        ],
        [
            0.02592811654510452,
            0.023298084510355022,
            0.0016353546626984017,
            0.4095728814208817,
            0.11904761904761904,
            2.653912646674754,
            5.958904070085146,
            0.0,
            0.05240885416666663,
        ],
        [
            0.02577406217442221,
            0.023298742903822882,
            0.0010540674603174611,
            0.26526115912214726,
            0.19047619047619047,
            2.9652739168753994,
            8.620689305633274,
            0.0,
            0.042643229166666685,
        ],
        [
            0.02527115521328122,
            0.02278830066248352,
            0.0016818576388888868,
            0.4322676246144157,
            0.16666666666666666,
            2.7565872496185886,
            5.950634239689063,
            0.0,
            0.04296875,
        ],
    ];
    assert_rows(&rows, &expected);
}

#[test]
fn equal_images_differ_by_nothing() {
    let [t, ..] = specimen(1);
    let (rows, _) = compare(&t, &t, None, None, &SETTINGS).unwrap();
    assert!(
        rows.iter().all(|r| r.rmse == 0.0
            && r.mean_t == 0.0
            && r.block5_frac == 0.0
            && r.z4_frac.is_none())
    );
}

#[test]
fn three_equal_colours_match_one() {
    let [t, ..] = specimen(1);
    let tripled = Field {
        colours: 3,
        values: t.values.iter().flat_map(|&v| [v; 3]).collect(),
        ..t
    };
    assert_eq!(tripled.clone().matched(&t, "a.exr").unwrap(), t);
    let mut coloured = tripled;
    coloured.values[1] += 0.1;
    let error = coloured.clone().matched(&t, "a.exr").unwrap_err();
    assert_eq!(
        error,
        "a.exr has 3 different colours, the reference is monochromatic"
    );
    assert!(
        t.matched(&coloured, "a.exr")
            .unwrap_err()
            .contains("1 colours, the reference 3")
    );
}

#[test]
fn unusable_input_is_refused() {
    let [mut t, r, ..] = specimen(1);
    let block = Settings {
        block: 8,
        floor: 0.0,
    };
    assert!(
        compare(&t, &r, None, None, &block)
            .unwrap_err()
            .contains("--block is 8, expected 2 to 6")
    );
    let floor = Settings {
        block: 3,
        floor: -1.0,
    };
    assert!(
        compare(&t, &r, None, None, &floor)
            .unwrap_err()
            .contains("--floor is -1")
    );
    t.values[3] = f64::NAN;
    assert_eq!(
        compare(&t, &r, None, None, &SETTINGS).unwrap_err(),
        "1 values of the test image are not finite, expected none"
    );
    let small = Field {
        width: 2,
        height: 1,
        values: vec![0.0; 8],
        ..t
    };
    assert!(
        small
            .matched(&r, "a.exr")
            .unwrap_err()
            .starts_with("a.exr is 2x1, the reference 7x6")
    );
}
