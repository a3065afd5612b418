//! Scenes for tests of sources, and the numbers that these are made of.

use crate::sampler::SampleStream;
use crate::scene::{BuiltScene, Overrides, build, read_text};

/// A scene of the given content, whose paths end at the first vertex.
pub(super) fn built(content: &str) -> BuiltScene {
    let text = format!(
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='2'/></integrator>
         <sensor type='perspective'/>{content}</scene>"
    );
    let document = read_text(&text, "test.xml".as_ref(), &[]).unwrap();
    build(&document, Overrides::default()).unwrap()
}

/// Six uniform numbers of a source.
pub(super) fn numbers(source: u64) -> [f64; 6] {
    let stream = SampleStream::new(11, 0, source);
    let [a, b, c] = [0, 2, 4].map(|dimension| stream.pair(dimension));
    [a[0], a[1], b[0], b[1], c[0], c[1]].map(f64::from)
}
