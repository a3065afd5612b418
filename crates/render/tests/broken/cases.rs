//! Broken scenes and meshes: what each is called, its text, and what the refusal says.
//!
//! An expected text that starts with a digit follows right after `FILE:`; another one stands somewhere in the refusal.

/// Name, text, expected refusal.
pub(crate) type Case = (&'static str, &'static str, &'static str);

/// A scene with every kind of element in it.
pub(crate) const VALID: &str = r##"<?xml version="1.0" encoding="utf-8"?>
<!-- é -->
<scene version="3.0.0">
    <default name="spp" value="64"/>
    <path value="parts"/>
    <include filename="light.xml"/>
    <sensor type="perspective">
        <float name="fov" value="32"/>
        <transform name="to_world">
            <lookat origin="0.3, 2.4, 6" target="0, 0, 0" up="0, 1, 0"/>
            <matrix value="1 0 0 0 1 0 0 0 1"/>
        </transform>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
    </sensor>
    <bsdf type="diffuse" id="grey"><rgb name="reflectance" value="#808080"/></bsdf>
    <alias id="grey" as="gray"/>
    <shape type="obj">
        <string name="filename" value="a.obj"/>
        <boolean name="face_normals" value="true"/>
        <point name="p" x="1" y="2" z="3"/>
        <vector name="v" value="1, 2, 3"/>
        <spectrum name="s" value="400:0.1, 700:0.9"/>
        <spectrum name="t" filename="a.spd"/>
        <transform name="to_world"><rotate y="1" angle="30"/><scale x="2"/><translate z="1"/></transform>
        <ref id="gray"/>
    </shape>
</scene>
"##;

/// A mesh with every statement that makes triangles.
pub(crate) const OBJ: &str = "# é\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\n\
                       f 1/1/1 2/1/1 3/1/1\nf -2//1 -1//1 3 1\n";

/// A scene with this in it, from line 2 on.
pub(crate) fn inside(text: &str) -> String {
    format!("<scene version='3.0.0'>\n{text}\n</scene>")
}

/// Whole files.
#[rustfmt::skip]
pub(crate) const BROKEN: &[Case] = &[
    ("empty file", "", "1:1: the file is empty, expected a scene"),
    ("blank file", " \n\n", "1:1: the file is empty, expected a scene"),
    ("byte order mark only", "\u{feff}", "1:1: the file is empty, expected a scene"),
    ("comment only", "<!-- a -->", "1:11: no element in the file, expected a scene"),
    ("no XML", "hello", "1:1: the XML is malformed: unknown token"),
    ("zero byte", "<scene version='3.0.0'>\0</scene>", "1:24: the XML is malformed: a non-XML character"),
    ("wrong end tag", "<scene version='3.0.0'>\n</scenes>", "2:1: the XML is malformed: expected 'scene' tag, not 'scenes'"),
    ("two roots", "<scene version='3.0.0'/>\n<scene version='3.0.0'/>", "2:1: the XML is malformed: unknown token"),
    ("attribute twice", "<scene version='3.0.0' version='3.0.0'/>", "1:24: the XML is malformed: attribute 'version' is already defined"),
    ("attribute without quotes", "<scene version=3/>", "1:16: the XML is malformed: expected a quote not '3'"),
    ("unknown entity", "<scene version='3.0.0' id='&a;'/>", "1:28: the XML is malformed: unknown entity reference 'a'"),
    ("wrong root", "<shape version='3.0.0' type='cube'/>", "1:1: the outermost element is 'shape', expected 'scene'"),
    ("no version", "<scene/>", "1:1: element 'scene' has no attribute 'version', expected version=\"…\""),
    ("old version", "<scene version='0.5.0'/>", "1:8: version '0.5.0' is the older dialect"),
    ("future version", "<scene version='30'/>", "1:8: attribute 'version' of scene is '30', expected a version such as '3.0.0'"),
    ("version in words", "<scene version='three'/>", "1:8: attribute 'version' of scene is 'three', expected"),
    ("namespace", "<scene version='3.0.0' xmlns='http://a'/>", "1:1: element 'scene' is in an XML namespace, expected none"),
    ("reference to the scene", "<scene version='3.0.0' id='a'><ref id='a'/></scene>", "1:31: the reference names an object around it"),
    ("attribute of the root", "<scene version='3.0.0' versoin='1'/>", "1:24: unknown attribute 'versoin' of scene, did you mean 'version'?"),
];

/// What stands in a scene from line 2 on.
#[rustfmt::skip]
pub(crate) const BROKEN_INSIDE: &[Case] = &[
    ("text", "a <bsdf type='a'/>", "2:1: text 'a' inside element 'scene', expected elements only"),
    ("CDATA", "<![CDATA[a]]>", "inside element 'scene', expected elements only"),
    ("unknown element", "<bdsf type='a'/>", "2:1: unknown element 'bdsf', did you mean 'bsdf'?"),
    ("scene in a scene", "<scene version='3.0.0'/>", "2:1: a scene inside an object, expected it outermost only"),
    ("no type", "<bsdf/>", "2:1: element 'bsdf' has no attribute 'type', expected type=\"…\""),
    ("empty type", "<bsdf type=''/>", "2:7: attribute 'type' of bsdf is '', expected a text"),
    ("unknown attribute", "<bsdf typ='a'/>", "2:7: unknown attribute 'typ' of bsdf, did you mean 'type'?"),
    ("empty id", "<bsdf type='a' id=''/>", "2:16: attribute 'id' of bsdf '' is '', expected a text"),
    ("id twice", "<bsdf type='a' id='a'/>\n<bsdf type='a' id='a'/>", "3:1: id 'a' is taken by the object at"),
    ("no name", "<float value='1'/>", "2:1: element 'float' has no attribute 'name', expected name=\"…\""),
    ("name twice", "<bsdf type='a'><float name='x' value='1'/><float name='x' value='1'/></bsdf>", "2:43: second parameter 'x', the first is at"),
    ("child with the name of a parameter", "<bsdf type='a'><float name='x' value='1'/><texture name='x' type='t'/></bsdf>", "2:43: second parameter 'x'"),
    ("no number", "<float name='a' value='1.0abc'/>", "2:17: attribute 'value' of float 'a' is '1.0abc', expected a number"),
    ("empty number", "<float name='a' value=''/>", "2:17: attribute 'value' of float 'a' is '', expected a text"),
    ("not a number", "<float name='a' value='NaN'/>", "2:17: attribute 'value' of float 'a' is 'NaN', expected a finite number"),
    ("infinity", "<float name='a' value='-inf'/>", "2:17: attribute 'value' of float 'a' is '-inf', expected a finite number"),
    ("too large a number", "<float name='a' value='1e309'/>", "is '1e309', expected a finite number"),
    ("fraction for an integer", "<integer name='a' value='1.5'/>", "2:19: attribute 'value' of integer 'a' is '1.5', expected an integer"),
    ("too large an integer", "<integer name='a' value='9223372036854775808'/>", "expected an integer of at most 9223372036854775807"),
    ("too small an integer", "<integer name='a' value='-9223372036854775809'/>", "expected an integer of at least -9223372036854775808"),
    ("number for a boolean", "<boolean name='a' value='1'/>", "2:19: attribute 'value' of boolean 'a' is '1', expected 'true' or 'false'"),
    ("two coordinates", "<point name='a' x='1' y='2'/>", "2:1: element 'point' has no attribute 'z', expected z=\"…\""),
    ("two forms of a point", "<point name='a' x='1' value='1,2,3'/>", "2:17: attribute 'value' beside 'x', 'y' or 'z', expected one of the two forms"),
    ("four coordinates", "<vector name='a' value='1 2 3 4'/>", "is '1 2 3 4', expected one or three numbers"),
    ("infinite coordinate", "<vector name='a' value='1 2 inf'/>", "expected a finite number"),
    ("half a colour", "<rgb name='a' value='#fff'/>", "is '#fff', expected a colour such as '#ff8000'"),
    ("colour in words", "<rgb name='a' value='red'/>", "is 'red', expected a number"),
    ("falling wavelengths", "<spectrum name='a' value='500:1, 400:1'/>", "expected rising wavelengths"),
    ("one wavelength", "<spectrum name='a' value='500:1'/>", "expected at least two wavelengths"),
    ("half a pair", "<spectrum name='a' value='400:, 500:1'/>", "expected a number"),
    ("infinite wavelength", "<spectrum name='a' value='400:1, inf:1'/>", "expected a finite number"),
    ("negative wavelength", "<spectrum name='a' value='-4:1, 500:1'/>", "expected positive wavelengths in nm"),
    ("empty spectrum", "<spectrum name='a' value=''/>", "2:20: attribute 'value' of spectrum 'a' is '', expected"),
    ("no spectrum", "<spectrum name='a'/>", "2:1: element 'spectrum' has neither 'value' nor 'filename', expected one of the two"),
    ("two spectra", "<spectrum name='a' value='1' filename='b'/>", "2:30: attribute 'filename' beside 'value', expected one of the two"),
    ("missing spectrum", "<spectrum name='a' filename='none.spd'/>", "2:20: no file 'none.spd', looked in"),
    ("folder for a spectrum", "<spectrum name='a' filename='parts'/>", "2:20: 'parts' is a directory, expected a file"),
    ("mesh for a spectrum", "<spectrum name='a' filename='parts/a.obj'/>", "2: 'o a' found, expected a number"),
    ("translate outside", "<translate x='1'/>", "2:1: element 'translate' outside a transform, put it into <transform name=\"to_world\">"),
    ("unknown operation", "<transform name='a'><rotat angle='1'/></transform>", "2:21: unknown element 'rotat' in a transform, did you mean 'rotate'?"),
    ("no axis", "<transform name='a'><rotate angle='1'/></transform>", "2:21: the axis of the rotation is zero, expected a direction"),
    ("no angle", "<transform name='a'><rotate x='1'/></transform>", "2:21: element 'rotate' has no attribute 'angle', expected angle=\"…\""),
    ("camera in its target", "<transform name='a'><lookat origin='1 1 1' target='1 1 1'/></transform>", "2:21: 'origin' and 'target' are the same point, expected two points"),
    ("camera along up", "<transform name='a'><lookat origin='0 0 0' target='0 1 0' up='0 2 0'/></transform>", "2:21: 'up' is parallel to the line of sight, expected another direction"),
    ("ten numbers", "<transform name='a'><matrix value='1 2 3 4 5 6 7 8 9 10'/></transform>", "2:29: attribute 'value' of matrix is '1 2 3 4 5 6 7 8 9 10', expected 9 or 16 numbers"),
    ("projection", "<transform name='a'><matrix value='1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0'/></transform>", "expected a last row of 0, 0, 0, 1"),
    ("overflow", "<transform name='a'><scale value='1e300'/><scale value='1e300'/></transform>", "2:43: the transform has entries too large for a number"),
    ("undefined name", "<float name='a' value='$b'/>", "2:17: '$b' has no value, expected <default name=\"b\" …/> before it or -D b=VALUE"),
    ("lone dollar", "<string name='a' value='5$'/>", "2:18: '$' has no value, write '\\$' for a dollar sign"),
    ("default defined by itself", "<default name='a' value='$a'/>", "2:19: '$a' has no value"),
    ("default without value", "<default name='a'/>", "2:1: element 'default' has no attribute 'value', expected value=\"…\""),
    ("reference to nothing", "<ref id='a'/>", "2:1: no object has the id 'a', expected an object with id='a'"),
    ("reference without id", "<ref/>", "2:1: element 'ref' has no attribute 'id', expected id=\"…\""),
    ("reference to itself", "<bsdf type='a' id='a'><ref id='a'/></bsdf>", "2:23: the reference names an object around it, expected one that does not contain it"),
    ("alias to nothing", "<alias id='a' as='b'/>", "2:1: no object has the id 'a', expected an object with id='a'"),
    ("alias that is taken", "<bsdf type='a' id='a'/><alias id='a' as='a'/>", "2:24: id 'a' is taken by the object at"),
    ("path to nothing", "<path value='none'/>", "2:7: no folder 'none', looked in"),
    ("path to a file", "<path value='light.xml'/>", "2:7: no folder 'light.xml', looked in"),
    ("path in an object", "<bsdf type='a'><path value='parts'/></bsdf>", "2:16: a path inside an object, expected it in the scene only"),
    ("include of nothing", "<include filename='none.xml'/>", "2:10: no file 'none.xml', looked in"),
    ("include of a folder", "<include filename='parts'/>", "2:10: 'parts' is a directory, expected a file"),
    ("include of itself", "<include filename='scene.xml'/>", "2:10: file 'scene.xml' includes itself, expected no circle of includes"),
    ("include of a mesh", "<include filename='parts/a.obj'/>", "1:1: the XML is malformed"),
    ("child of a value", "<float name='a' value='1'><bsdf type='a'/></float>", "2:27: element 'bsdf' inside element 'float', expected nothing inside"),
];

/// Parameters of `<bsdf type='a'>`, from line 3 on, that plugins ask for: a number `alpha`, a number `fov` that must
/// be given, an integer `sample_count`, …
#[rustfmt::skip]
pub(crate) const BROKEN_USE: &[Case] = &[
    ("string for a number", "<string name='alpha' value='rough'/>", "3:1: parameter 'alpha' of bsdf 'a' is a string ('rough'), expected a number"),
    ("table for a number", "<spectrum name='alpha' value='400:1, 500:2'/>", "is a spectrum with several wavelengths, expected a number"),
    ("object for a number", "<texture name='alpha' type='t'/>", "3:1: parameter 'alpha' of bsdf 'a' is a texture 't', expected a number"),
    ("no number", "", "2:1: bsdf 'a' has no parameter 'fov', expected a number"),
    ("float for an integer", "<float name='fov' value='1'/><float name='sample_count' value='4'/>", "is a float (4), expected an integer"),
    ("string for a boolean", "<float name='fov' value='1'/><string name='face_normals' value='true'/>", "is a string ('true'), expected a boolean"),
    ("unknown choice", "<float name='fov' value='1'/><string name='distribution' value='ggxx'/>", "is 'ggxx', expected 'beckmann' or 'ggx', did you mean 'ggx'?"),
    ("number for a point", "<float name='fov' value='1'/><float name='p' value='4'/>", "is a float (4), expected a point"),
    ("point for a transform", "<float name='fov' value='1'/><point name='to_world' value='4'/>", "is a point, expected a transform"),
    ("flat transform", "<float name='fov' value='1'/><transform name='to_world'><scale x='0'/></transform>", "3:30: transform 'to_world' of bsdf 'a' maps space to a plane"),
    ("matrix of rank two", "<float name='fov' value='1'/><transform name='to_world'><matrix value='1 2 3 2 4 6 0 0 1'/></transform>", "3:30: transform 'to_world' of bsdf 'a' maps space to a plane"),
    ("no mesh", "<float name='fov' value='1'/>", "2:1: bsdf 'a' has no parameter 'filename', expected the name of a file"),
    ("missing mesh", "<float name='fov' value='1'/><string name='filename' value='none.obj'/>", "3:30: no file 'none.obj', looked in"),
    ("folder for a mesh", "<float name='fov' value='1'/><string name='filename' value='parts'/>", "3:30: 'parts' is a directory, expected a file"),
    ("empty file name", "<float name='fov' value='1'/><string name='filename' value=''/>", "3:30: the file name is empty, expected the name of a file"),
    ("number for an object", "<float name='fov' value='1'/><string name='filename' value='light.xml'/><float name='texture' value='1'/>", "3:73: parameter 'texture' of bsdf 'a' is a float (1), expected an object"),
    ("too bright a surface", "<float name='fov' value='1'/><string name='filename' value='light.xml'/><rgb name='reflectance' value='0 0 2'/>", "3:73: spectrum 'reflectance' of bsdf 'a' contains 2, expected a fraction between 0 and 1"),
    ("misspelt parameter", "<float name='fov' value='1'/><string name='filename' value='light.xml'/><float name='alhpa' value='1'/>", "3:73: unknown parameter 'alhpa' in bsdf 'a', did you mean 'alpha'?"),
    ("camel case", "<float name='fov' value='1'/><string name='filename' value='light.xml'/><transform name='toWorld'/>", "3:73: unknown parameter 'toWorld' in bsdf 'a', did you mean 'to_world'?"),
    ("unwanted child", "<float name='fov' value='1'/><string name='filename' value='light.xml'/><film type='f'/>", "3:73: unexpected film 'f' in bsdf 'a', expected none there"),
];

/// Meshes.
#[rustfmt::skip]
pub(crate) const BROKEN_OBJ: &[Case] = &[
    ("two coordinates", "v 1 2", "1: 'v' with 2 numbers, expected 3"),
    ("words", "v a b c", "1: 'a' in 'v' is no number, expected 3 or more"),
    ("not a number", "v 0 0 0\nv nan 0 0", "2: 'nan' in 'v' is not finite in single precision, expected a finite number"),
    ("infinity", "v 0 0 -inf", "1: '-inf' in 'v' is not finite in single precision, expected a finite number"),
    ("too large", "v 0 0 1e40", "1: '1e40' in 'v' is not finite in single precision, expected a finite number"),
    ("infinite normal", "vn 0 0 inf", "1: 'inf' in 'vn' is not finite in single precision, expected a finite number"),
    ("no texture coordinate", "vt", "1: 'vt' with 0 numbers, expected 1"),
    ("face of two", "v 0 0 0\nf 1 1", "2: face with 2 corners, expected at least 3"),
    ("face of none", "f", "1: face with 0 corners, expected at least 3"),
    ("index too large", "v 0 0 0\n\nf 1 1 2", "3: face names vertex 2, expected at most 1, the number in the file"),
    ("index zero", "v 0 0 0\nf 0 1 1", "2: index 0 in a face, expected 1 for the first vertex"),
    ("index too far back", "v 0 0 0\nf -1 -1 -2", "2: index -2 in a face, there are 1 before this line"),
    ("index of 20 digits", "v 0 0 0\nf 1 1 18446744073709551615", "2: index '18446744073709551615' in a face, expected an integer"),
    ("index of 32 bits", "v 0 0 0\nf 1 1 4294967296", "2: face names vertex 4294967296, expected at most 1, the number in the file"),
    ("missing texture coordinate", "v 0 0 0\nf 1/1 1/1 1/1", "2: face names texture coordinate 1, expected at most 0, the number in the file"),
    ("texture coordinate too far back", "v 0 0 0\nvt 0 0\nf 1/-9 1/1 1/1", "3: index -9 in a face, there are 1 before this line"),
    ("index of 64 bits", "v 0 0 0\nvn 0 0 1\nf 1//9223372036854775807 1 1", "3: face names normal 9223372036854775807, expected at most 1"),
    ("missing normal", "v 0 0 0\nf 1//7 1//7 1//7", "2: face names normal 7, expected at most 0, the number in the file"),
    ("four parts", "v 0 0 0\nf 1/1/1/1 1 1", "2: face corner '1/1/1/1', expected v, v/vt, v//vn or v/vt/vn"),
    ("nothing but slashes", "f // // //", "1: face corner '//', expected v, v/vt, v//vn or v/vt/vn"),
    ("unknown statement", "v 0 0 0\nvertex 0 0 0", "2: unknown statement 'vertex', expected 'v', 'vn', 'vt' or 'f'"),
    ("XML", VALID, "1: unknown statement '<?xml', expected 'v', 'vn', 'vt' or 'f'"),
];

fn nested(element: &str, depth: usize) -> String {
    let name = element.split(' ').next().unwrap_or_default();
    format!("<{element}>").repeat(depth) + &format!("</{name}>").repeat(depth)
}

/// Small texts that stand for much: name, text, expected refusal.
#[rustfmt::skip]
pub(crate) fn bombs() -> Vec<(&'static str, String, &'static str)> {
    let laughs = "<!DOCTYPE a [<!ENTITY a 'ha'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;'>]>\n<scene version='3.0.0'>&b;</scene>";
    let links = |count: usize, link: &dyn Fn(usize) -> String| -> String { (0..count).map(link).collect() };
    let doubling = links(60, &|i| format!("<default name='d{}' value='$d{i}$d{i}'/>", i + 1));
    let shared = links(60, &|i| format!("<bsdf type='t' id='b{}'><ref id='b{i}'/><ref id='b{i}'/></bsdf>", i + 1));
    let chain = links(10_000, &|i| format!("<bsdf type='t' id='b{}'><ref id='b{i}'/></bsdf>", i + 1));
    let attributes = links(20_000, &|i| format!("a{i}='' "));
    let first = "<bsdf type='t' id='b0'/>";
    let digits = "9".repeat(400);
    vec![
        ("10,000 nested objects", inside(&nested("bsdf type='a'", 10_000)), "2:961: objects are nested deeper than 64 levels, expected fewer"),
        ("10,000 nested values", inside(&nested("float name='a' value='1'", 10_000)), "2:27: element 'float' inside element 'float', expected nothing inside"),
        ("10,000 nested transforms", inside(&nested("transform name='a'", 10_000)), "2:21: unknown element 'transform' in a transform, expected"),
        ("10,000 unclosed elements", "<a>".repeat(10_000), "1:30001: the file ends inside an element, expected its end tag"),
        ("entities that multiply", laughs.to_owned(), "1:1: a document type declaration, expected none, entities are not supported"),
        ("defaults that multiply", inside(&("<default name='d0' value='xxxx'/>".to_owned() + &doubling)), "look for defaults that contain each other"),
        ("references that multiply", inside(&(first.to_owned() + &shared)), "references repeat an object more than 1000000 times, expected fewer"),
        ("a long chain of references", inside(&(first.to_owned() + &chain)), "objects are nested deeper than 64 levels, expected fewer"),
        ("a number of 400 digits", inside(&format!("<float name='a' value='{digits}'/>")), "expected a finite number"),
        ("an integer of 400 digits", inside(&format!("<integer name='a' value='{digits}'/>")), "expected an integer of at most 9223372036854775807"),
        ("a name of a million letters", inside(&format!("<{} a=''/>", "x".repeat(1_000_000))), "2:1: unknown element 'xxx"),
        ("20,000 attributes", inside(&format!("<bsdf {attributes}/>")), "2:7: unknown attribute 'a0' of bsdf, expected 'type', 'id' or 'name'"),
    ]
}
