//! `<transform>`: translate, rotate, scale, lookat and matrix, applied in the order in which they are listed.

use glam::{DMat3, DMat4, DVec3};

use super::defines::Defines;
use super::element::Element;
use super::error::{SceneError, quoted, suggestion};
use super::number;
use super::source::Source;

const OPERATIONS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// The product of the operations inside a `<transform>`; the first one listed acts first.
pub(super) fn read(
    transform: &Element<'_>,
    source: &Source,
    defines: &mut Defines,
) -> Result<DMat4, SceneError> {
    let mut product = DMat4::IDENTITY;
    for node in transform.children()? {
        let element = Element::new(node, source, defines)?;
        product = operation(&element)? * product;
        element.no_children()?;
        if !product.is_finite() {
            return Err(element.error("the transform has entries too large for a number"));
        }
    }
    Ok(product)
}

fn operation(element: &Element<'_>) -> Result<DMat4, SceneError> {
    match element.tag {
        "translate" => Ok(DMat4::from_translation(components(element, &[], 0.0)?)),
        "scale" => Ok(DMat4::from_scale(components(element, &[], 1.0)?)),
        "rotate" => rotate(element),
        "lookat" | "look_at" => look_at(element),
        "matrix" => matrix(element),
        other => Err(element.error(format!(
            "unknown element {} in a transform{}",
            quoted(other),
            suggestion(other, &OPERATIONS)
        ))),
    }
}

/// `x`, `y`, `z`, or `value` with one or three numbers.
fn components(element: &Element<'_>, others: &[&str], absent: f64) -> Result<DVec3, SceneError> {
    element.allow(&[&["x", "y", "z", "value"], others].concat())?;
    if let Some(value) = element.get("value") {
        if ["x", "y", "z"]
            .iter()
            .any(|axis| element.get(axis).is_some())
        {
            return Err(value
                .position
                .error("attribute 'value' beside 'x', 'y' or 'z', expected one of the two forms"));
        }
        return Ok(value.parse(number::one_or_triple)?.into());
    }
    let mut vector = [absent; 3];
    for (component, name) in vector.iter_mut().zip(["x", "y", "z"]) {
        if let Some(attribute) = element.get(name) {
            *component = attribute.parse(number::float)?;
        }
    }
    Ok(vector.into())
}

fn rotate(element: &Element<'_>) -> Result<DMat4, SceneError> {
    let axis = components(element, &["angle"], 0.0)?;
    let degrees = element.require("angle")?.parse(number::float)?;
    if axis == DVec3::ZERO {
        return Err(element.error("the axis of the rotation is zero, expected a direction"));
    }
    // Rodrigues' formula with the axis as it stands: one that is not of unit length stretches, as in Mitsuba
    let (sin, cos) = degrees.to_radians().sin_cos();
    let column = |e: DVec3| e * cos + axis.cross(e) * sin + axis * (axis.dot(e) * (1.0 - cos));
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(column);
    Ok(DMat4::from_mat3(DMat3::from_cols(x, y, z)))
}

/// Local +z looks from `origin` to `target`, local +y is the part of `up` across it, local +x = y × z.
fn look_at(element: &Element<'_>) -> Result<DMat4, SceneError> {
    element.allow(&["origin", "target", "up"])?;
    let point = |name| -> Result<DVec3, SceneError> {
        Ok(element.require(name)?.parse(number::triple)?.into())
    };
    let (origin, target) = (point("origin")?, point("target")?);
    let up = match element.get("up") {
        Some(_) => point("up")?,
        None => DVec3::ZERO,
    };
    let forward = unit(target - origin).ok_or_else(|| {
        element.error("'origin' and 'target' are the same point, expected two points")
    })?;
    let up = if up == DVec3::ZERO {
        any_across(forward)
    } else {
        up
    };
    let left = unit(up)
        .and_then(|up| Some(up.cross(forward)).filter(|side| side.length() > 1e-12))
        .and_then(unit)
        .ok_or_else(|| {
            element.error("'up' is parallel to the line of sight, expected another direction")
        })?;
    let axes = DMat3::from_cols(left, forward.cross(left), forward);
    Ok(DMat4::from_translation(origin) * DMat4::from_mat3(axes))
}

/// Unit vector along `v`, for lengths whose square would overflow or vanish too.
fn unit(v: DVec3) -> Option<DVec3> {
    (v / v.abs().max_element()).try_normalize()
}

/// A unit vector across the unit vector `n`, the same one as in Mitsuba.
///
/// Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6 (2017), the first vector of listing 3.
fn any_across(n: DVec3) -> DVec3 {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    DVec3::new(
        1.0 + sign * n.x * n.x * a,
        sign * n.x * n.y * a,
        -sign * n.x,
    )
}

/// 16 numbers row by row, or the 9 of the linear part.
fn matrix(element: &Element<'_>) -> Result<DMat4, SceneError> {
    element.allow(&["value"])?;
    let value = element.require("value")?;
    let m = value.parse(number::floats)?;
    match m.len() {
        9 => Ok(DMat4::from_mat3(DMat3::from_cols_slice(&m).transpose())),
        16 if m[12..] == [0.0, 0.0, 0.0, 1.0] => Ok(DMat4::from_cols_slice(&m).transpose()),
        16 => Err(value.expected("a last row of 0, 0, 0, 1")),
        _ => Err(value.expected("9 or 16 numbers")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transform(inside: &str) -> Result<DMat4, String> {
        let text = format!("<transform>{inside}</transform>");
        let source = Source::new(std::path::Path::new("s.xml"), &text);
        let document = roxmltree::Document::parse(&source.text).unwrap();
        let mut defines = Defines::new(&[]).unwrap();
        Element::new(document.root_element(), &source, &mut defines)
            .and_then(|element| read(&element, &source, &mut defines))
            .map_err(|error| error.to_string())
    }

    fn moved(inside: &str, point: [f64; 3]) -> DVec3 {
        transform(inside).unwrap().transform_point3(point.into())
    }

    fn close(a: DVec3, b: [f64; 3]) {
        assert!((a - DVec3::from(b)).length() < 1e-12, "{a} is not {b:?}");
    }

    #[test]
    fn the_first_operation_listed_acts_first() {
        let inside = "<scale value='2'/><rotate z='1' angle='90'/><translate x='1'/>";
        close(moved(inside, [1.0, 0.0, 0.0]), [1.0, 2.0, 0.0]);
    }

    #[test]
    fn components_left_out_are_neutral() {
        close(moved("<scale y='3'/>", [1.0, 1.0, 1.0]), [1.0, 3.0, 1.0]);
        close(moved("<translate y='3'/>", [1.0; 3]), [1.0, 4.0, 1.0]);
        close(
            moved("<translate value='1 2,3'/>", [0.0; 3]),
            [1.0, 2.0, 3.0],
        );
    }

    #[test]
    fn a_camera_looks_along_plus_z_with_y_up() {
        let m = transform("<lookat origin='0,0,5' target='0,0,0' up='0,2,1'/>").unwrap();
        close(m.transform_point3(DVec3::ZERO), [0.0, 0.0, 5.0]);
        close(m.transform_vector3(DVec3::Z), [0.0, 0.0, -1.0]);
        close(m.transform_vector3(DVec3::Y), [0.0, 1.0, 0.0]);
        close(m.transform_vector3(DVec3::X), [-1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_camera_without_up_gets_a_frame_of_its_own() {
        for target in ["0,0,1", "0,0,-1", "1,2,3", "1e200,1,0"] {
            let m = transform(&format!("<lookat origin='0,0,0' target='{target}'/>")).unwrap();
            assert!((m.determinant() - 1.0).abs() < 1e-12, "{target}");
        }
    }

    #[test]
    fn matrices_are_written_row_by_row() {
        let inside = "<matrix value='1 0 0 5  0 2 0 6  0 0 3 7  0 0 0 1'/>";
        close(moved(inside, [1.0; 3]), [6.0, 8.0, 10.0]);
        let inside = "<matrix value='0 1 0, 0 0 1, 1 0 0'/>";
        close(moved(inside, [1.0, 2.0, 3.0]), [2.0, 3.0, 1.0]);
    }

    #[test]
    fn what_is_no_rigid_or_affine_map_is_refused() {
        for (inside, message) in [
            (
                "<rotate angle='9'/>",
                "the axis of the rotation is zero, expected a direction",
            ),
            (
                "<rotate x='1'/>",
                "element 'rotate' has no attribute 'angle', expected angle=\"…\"",
            ),
            (
                "<spin/>",
                "unknown element 'spin' in a transform, expected 'translate', 'rotate', 'scale', 'lookat' or 'matrix'",
            ),
            (
                "<lookAt/>",
                "unknown element 'lookAt' in a transform, did you mean 'lookat'?",
            ),
            (
                "<lookat origin='1,1,1' target='1,1,1'/>",
                "'origin' and 'target' are the same point, expected two points",
            ),
            (
                "<lookat origin='0,0,0' target='0,9,0' up='0,1,0'/>",
                "'up' is parallel to the line of sight, expected another direction",
            ),
        ] {
            assert_eq!(
                transform(inside).unwrap_err(),
                format!("s.xml:1:12: {message}")
            );
        }
        for (inside, message) in [
            ("<scale x='1' value='2'/>", "beside 'x', 'y' or 'z'"),
            (
                "<scale x='nan'/>",
                "attribute 'x' of scale is 'nan', expected a finite number",
            ),
            (
                "<matrix value='1 2 3'/>",
                "is '1 2 3', expected 9 or 16 numbers",
            ),
            (
                "<matrix value='1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1'/>",
                "expected a last row of 0, 0, 0, 1",
            ),
            (
                "<scale value='1e200'/><scale value='1e200'/>",
                "entries too large",
            ),
            ("<translate><scale/></translate>", "expected nothing inside"),
        ] {
            let error = transform(inside).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }
}
