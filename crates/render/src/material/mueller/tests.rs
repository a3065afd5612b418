//! Tests of given Mueller matrices: sides, tables, what is refused.

use std::io::Write as _;

use super::super::retarder::Retarder;
use super::super::rotator::Rotator;
use super::super::testing::{broken_reciprocity, direction, matrix, read};
use super::*;

fn mueller(parameters: &str) -> Result<MuellerElement, String> {
    read("mueller", parameters, MuellerElement::read)
}

fn of_matrix(text: &str, more: &str) -> Result<MuellerElement, String> {
    mueller(&format!("<string name='matrix' value='{text}'/>{more}"))
}

const QUARTER_WAVE: &str = "1 0 0 0  0 1 0 0  0 0 0 1  0 0 -1 0";
/// A depolarizing mixture of a polarizer, a retarder and a rotator.
const MIXTURE: &str =
    "0.7 0.1 0.05 0.02, 0.1 0.4 0.1 0.05, -0.02 -0.1 0.4 0.15, 0.03 -0.05 -0.15 0.35";

#[test]
fn a_quarter_wave_matrix_is_the_quarter_wave_plate_from_both_sides() {
    let element = of_matrix(QUARTER_WAVE, "<float name='theta' value='30'/>").unwrap();
    let retarder = read(
        "retarder",
        "<float name='theta' value='30'/>",
        Retarder::read,
    )
    .unwrap();
    for degrees in [0.0, 180.0] {
        let (o, axis) = (direction(degrees, 0.0), Vec3A::X);
        let [found, expected] = [
            matrix(&element, (o, axis), (-o, axis), Part::Straight, 550.0),
            matrix(&retarder, (o, axis), (-o, axis), Part::Straight, 550.0),
        ];
        assert!((found - expected).amax() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn elements_are_reciprocal_and_rotators_turn_alike_from_both_sides() {
    let element = of_matrix(MIXTURE, "<float name='theta' value='-20'/>").unwrap();
    let rotator = read("rotator", "<float name='angle' value='30'/>", Rotator::read).unwrap();
    for (degrees, azimuth) in [(0.0, 0.0), (40.0, 1.0), (75.0, 4.0)] {
        let o = direction(degrees, azimuth);
        assert!(broken_reciprocity(&element, (o, -o), Part::Straight, 550.0, 1.0) < 1e-6);
        assert!(broken_reciprocity(&rotator, (o, -o), Part::Straight, 550.0, 1.0) < 1e-6);
    }
    for o in [Vec3A::Z, -Vec3A::Z] {
        let m = matrix(
            &rotator,
            (o, Vec3A::X),
            (-o, Vec3A::X),
            Part::Straight,
            550.0,
        );
        // light along the first axis: 30° counter-clockwise, S1 = cos 60°, S2 = + sin 60°
        assert!((m[(1, 1)] - 0.5).abs() < 1e-6 && (m[(2, 1)] - 0.75f64.sqrt()).abs() < 1e-6);
    }
}

fn table(text: &str) -> (tempfile::TempDir, Result<MuellerElement, String>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let mut file = std::fs::File::create(&path).unwrap();
    file.write_all(text.as_bytes()).unwrap();
    let parameters = format!("<string name='filename' value='{}'/>", path.display());
    let element = mueller(&parameters).map_err(|e| e.replace(&path.display().to_string(), "FILE"));
    (folder, element)
}

const HEADER: &str =
    "wavelength_nm,angle_deg,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23,m30,m31,m32,m33\n";

fn grey(keys: &str, t: f64) -> String {
    format!("{keys},{t},0,0,0,0,{t},0,0,0,0,{t},0,0,0,0,{t}\n")
}

#[test]
fn tables_are_interpolated_over_wavelength_and_angle() {
    let rows = [
        grey("500,0", 0.2),
        grey("500,60", 0.4),
        grey("600,0", 0.6),
        grey("600,60", 1.0),
    ];
    let (_folder, element) = table(&format!("# made up\n{HEADER}{}", rows.concat()));
    let element = element.unwrap();
    for (wavelength, degrees, expected) in [
        (500.0, 0.0, 0.2),
        (550.0, 30.0, 0.55),
        (525.0, 15.0, 0.3625),
        (600.0, 60.0, 1.0),
        // the last angle holds
        (600.0, 80.0, 1.0),
        (575.0, 120.0, 0.85),
    ] {
        let o = direction(degrees, 0.2);
        let axis = super::super::testing::common_axis(o, -o);
        let m = matrix(&element, (o, axis), (-o, axis), Part::Straight, wavelength);
        assert!(
            (m[(0, 0)] - expected).abs() < 1e-6,
            "{wavelength} {degrees}"
        );
    }
    assert!(element.check_wavelengths([500.0, 600.0]).is_ok());
    assert_eq!(
        element
            .check_wavelengths([450.0, 450.0])
            .unwrap_err()
            .to_string(),
        "scene.xml:2:1: the table of bsdf 'mueller' is known from 500 to 600 nm, expected a table that holds 450 nm; \
         --wavelength or --bands choose others"
    );
}

#[test]
fn broken_tables_are_refused_at_their_line() {
    for (text, expected) in [
        (
            String::new(),
            "FILE: the file is empty, expected a header 'wavelength_nm angle_deg m00 m01 ... m33', with one or both of \
             the first two",
        ),
        (
            "angle,m00\n".to_owned(),
            "FILE:1: 'angle,m00', expected a header 'wavelength_nm angle_deg m00 m01 ... m33', with one or both of the \
             first two",
        ),
        (
            format!("{HEADER}500,0,1\n"),
            "FILE:2: 3 numbers in a row, expected 18",
        ),
        (
            format!("{HEADER}{}", grey("500,100", 0.5)),
            "FILE:2: an angle of 100 degrees, expected one from 0 to 90",
        ),
        (
            format!("{HEADER}{}{}", grey("500,0", 0.5), grey("600,10", 0.5)),
            "FILE: 2 matrices for 2 wavelengths and 2 angles, expected one for each pair",
        ),
        (
            format!("{HEADER}{}{}", grey("500,0", 0.5), grey("600,0", 1.5)),
            "FILE:3: Mueller matrix: it sends out 1.500000 times the power of some light, expected at most 1; divide \
             it by that",
        ),
    ] {
        assert_eq!(table(&text).1.err().unwrap_or_default(), expected, "{text}");
    }
}

#[test]
fn matrices_that_nothing_has_are_refused() {
    for (matrix, expected) in [
        (
            "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 -1",
            "scene.xml:2:1: 'matrix' of bsdf 'mueller': eigenvalue -0.500000 of its coherency matrix is negative at \
             m00 = 1, expected none below 0: no mixture of Jones matrices makes it",
        ),
        (
            "1 0.2 0 0 0.2 1 0 0 0 0 1 0 0 0 0 1",
            "scene.xml:2:1: 'matrix' of bsdf 'mueller': eigenvalue -0.009902 of its coherency matrix is negative at \
             m00 = 1, expected none below 0: no mixture of Jones matrices makes it",
        ),
        (
            "1 1 0 0 1 1 0 0 0 0 0 0 0 0 0 0",
            "scene.xml:2:1: 'matrix' of bsdf 'mueller': it sends out 2.000000 times the power of some light, expected \
             at most 1; divide it by that",
        ),
        (
            "1 0 0",
            "scene.xml:2:1: 'matrix' of bsdf 'mueller' is 3 numbers, expected 16 numbers, row by row",
        ),
        (
            "one",
            "scene.xml:2:1: 'matrix' of bsdf 'mueller' is 'one', expected 16 numbers, row by row",
        ),
    ] {
        assert_eq!(of_matrix(matrix, "").unwrap_err(), expected);
    }
    assert_eq!(
        mueller("").unwrap_err(),
        "scene.xml:1:24: bsdf 'mueller' has no matrix or two, expected either 'matrix' or 'filename'"
    );
    assert!(of_matrix(MIXTURE, "").is_ok());
}

#[test]
fn rounded_matrices_become_the_nearest_possible_ones() {
    // a polarizer, rounded to three digits
    let element = of_matrix("0.5 0.5 0 0 0.5 0.5 0 0 0 0 0.0002 0 0 0 0 0.0002", "").unwrap();
    let m = matrix(
        &element,
        (Vec3A::Z, Vec3A::X),
        (-Vec3A::Z, Vec3A::X),
        Part::Straight,
        550.0,
    );
    assert!((m[(0, 0)] - 0.5).abs() < 1e-3 && m[(2, 2)].abs() < 3e-4);
    let exact = Mueller::from(m);
    assert!(exact.is_passive(1e-6));
    let spectrum = csdm::CloudeSpectrum::of(&exact).unwrap();
    assert!(spectrum.check_realizable(1e-6).is_ok());
}

#[test]
fn mirrors_turn_their_back_to_nobody() {
    let mirror = of_matrix(
        "0.8 0 0 0 0 0.8 0 0 0 0 -0.8 0 0 0 0 -0.8",
        "<string name='mode' value='reflection'/>",
    )
    .unwrap();
    let at = super::super::testing::vertex(direction(40.0, 0.0));
    let departure = mirror.sample(&at, &[550.0], [0.5; 3]).unwrap();
    assert!((departure.direction - Vec3A::new(-at.o.x, -at.o.y, at.o.z)).length() < 1e-6);
    let behind = super::super::testing::vertex(direction(140.0, 0.0));
    assert!(mirror.sample(&behind, &[550.0], [0.5; 3]).is_none());
    let o = at.o;
    let off = broken_reciprocity(
        &mirror,
        (o, departure.direction),
        Part::Discrete(0),
        550.0,
        1.0,
    );
    assert!(off < 1e-6, "{off}");
}
