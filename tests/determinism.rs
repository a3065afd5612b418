//! Claim: an image is a function of scene, seed and sample count; not of threads, passes or the window that is rendered.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use brewster_tests::{SIGMAS, Shot, brewster, image_of, mean, repository};
use render::engine::{Limits, render};
use render::film::SpectralMode;
use render::image::StokesImage;
use render::scene::{Document, read, read_text};

const RGB: SpectralMode = SpectralMode::Rgb;

fn cornell() -> Document {
    read(&repository().join("scenes/cornell_spectral/scene.xml"), &[]).unwrap()
}

fn bits(image: &StokesImage) -> Vec<u32> {
    let variance = image.variance.as_ref().unwrap();
    image
        .stokes
        .iter()
        .chain(variance)
        .map(|v| v.to_bits())
        .collect()
}

/// Renders with so many threads; also the sample counts after each pass. Slow reports make short passes, and a limit of
/// time, however far, has the first one take a single sample.
fn with_threads(
    threads: usize,
    shot: &Shot,
    document: &Document,
    delay: Duration,
) -> (StokesImage, Vec<u64>) {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    let job = shot.job(document);
    let mut passes = Vec::new();
    let rendering = pool.install(|| {
        render(
            &job,
            Limits {
                time: (!delay.is_zero()).then_some(Duration::from_secs(3600)),
                ..Limits::default()
            },
            &AtomicBool::new(false),
            |progress| {
                passes.push(progress.samples);
                std::thread::sleep(delay);
            },
        )
    });
    (image_of(&job, &rendering), passes)
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    for mode in [RGB, SpectralMode::Single(600.0)] {
        let shot = Shot {
            size: Some([50, 37]),
            mode,
            ..Shot::new(8)
        };
        let [one, two, three] =
            [1, 2, 3].map(|n| bits(&with_threads(n, &shot, &cornell(), Duration::ZERO).0));
        assert!(one == two && one == three);
    }
}

/// What the program makes of a small image of a bundled scene, with these instructions and threads.
fn written(place: &Path, scene: &str, options: &[&str], wish: &str, threads: &str) -> Vec<u8> {
    let file = place.join("image.npy");
    let scene = repository().join("scenes").join(scene).join("scene.xml");
    let status = brewster()
        .env("BREWSTER_SIMD", wish)
        .args(["render", "--size", "24x18", "--quiet", "--threads", threads])
        .args(options)
        .arg("-o")
        .args([&file, &scene])
        .status()
        .unwrap();
    assert!(status.success(), "{scene:?} {options:?} {wish}");
    std::fs::read(&file).unwrap()
}

/// Scenes in colour, paths one by one among them, with samples alike in all pixels and spread.
const SHOTS: [(&str, &[&str]); 6] = [
    ("cornell_spectral", &["--rgb", "--spp", "16"]),
    ("showroom", &["--rgb", "--spp", "16"]),
    ("double_slit", &["--rgb", "--spp", "4"]),
    ("cornell_spectral", &["--rgb", "--spp", "64", "--adaptive"]),
    ("showroom", &["--target-error", "0.1", "--spp", "256"]),
    ("double_slit", &["--spp", "32", "--adaptive"]),
];

#[test]
fn the_instructions_of_the_processor_change_no_bit() {
    let place = tempfile::tempdir().unwrap();
    for (scene, options) in SHOTS {
        let [all, avx2, portable] =
            ["", "avx2", "portable"].map(|wish| written(place.path(), scene, options, wish, "2"));
        assert!(all == avx2 && all == portable, "{scene} {options:?}");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit_of_what_is_written() {
    let place = tempfile::tempdir().unwrap();
    for (scene, options) in SHOTS {
        let [one, two, three] =
            ["1", "2", "3"].map(|threads| written(place.path(), scene, options, "", threads));
        assert!(one == two && one == three, "{scene} {options:?}");
    }
}

#[test]
fn the_division_into_passes_changes_no_bit() {
    let shot = Shot {
        size: Some([20, 20]),
        ..Shot::new(5)
    };
    let (quick, few) = with_threads(2, &shot, &cornell(), Duration::ZERO);
    // a pass should last half a second: after a longer one the next takes a single sample
    let (slow, many) = with_threads(2, &shot, &cornell(), Duration::from_millis(550));
    assert_eq!(many, [1, 2, 3, 4, 5]);
    assert!(few.len() < many.len(), "{few:?}");
    assert!(bits(&quick) == bits(&slow));
}

#[test]
fn a_crop_is_cut_out_of_the_whole() {
    let whole = Shot {
        size: Some([40, 40]),
        ..Shot::new(4)
    };
    let crop = Shot {
        crop: Some([11, 5, 21, 30]),
        ..whole.clone()
    };
    let [whole, crop] =
        [whole, crop].map(|shot| with_threads(2, &shot, &cornell(), Duration::ZERO).0);
    assert_eq!((crop.width, crop.height), (21, 30));
    for y in 0..crop.height {
        for x in 0..crop.width {
            let (a, b) = (crop.stokes_at(x, y, 0), whole.stokes_at(x + 11, y + 5, 0));
            assert_eq!(a, b, "{x}, {y}");
        }
    }
}

#[test]
fn another_seed_gives_other_noise_about_the_same_mean() {
    let shot = Shot {
        size: Some([40, 40]),
        ..Shot::new(64)
    };
    let other = Shot {
        seed: 2,
        ..shot.clone()
    };
    let [a, b] = [shot, other].map(|shot| with_threads(2, &shot, &cornell(), Duration::ZERO).0);
    let same = a
        .stokes
        .chunks(4)
        .zip(b.stokes.chunks(4))
        .filter(|(a, b)| a[0] == b[0] && a[0] != 0.0)
        .count();
    assert!(same < 4, "{same} of 1600 pixels are equal");
    let ((a, ea), (b, eb)) = (mean(&a, 0), mean(&b, 0));
    for k in 0..4 {
        assert!(
            (a[k] - b[k]).abs() <= SIGMAS * ea[k].hypot(eb[k]),
            "S{k}: {a:?} {b:?}"
        );
    }
}

/// A lamp over a floor and a ball, all of them depolarizing.
const DULL: &str = "<scene version='3.0.0'>
    <integrator type='path'><integer name='max_depth' value='6'/></integrator>
    <sensor type='perspective'>
        <float name='fov' value='40'/>
        <transform name='to_world'><lookat origin='0, 2, 6' target='0, 0, 0' up='0, 1, 0'/></transform>
        <film type='hdrfilm'><integer name='width' value='30'/><integer name='height' value='24'/></film>
    </sensor>
    <emitter type='constant'><float name='radiance' value='0.3'/></emitter>
    <shape type='rectangle'>
        <transform name='to_world'><scale value='5'/><rotate x='1' angle='-90'/><translate y='-1'/></transform>
        <bsdf type='diffuse'><float name='reflectance' value='0.6'/></bsdf>
    </shape>
    <shape type='sphere'><bsdf type='diffuse'><float name='reflectance' value='0.8'/></bsdf></shape>
    <shape type='rectangle'>
        <transform name='to_world'><rotate x='1' angle='90'/><translate y='3'/></transform>
        <emitter type='area'><float name='radiance' value='4'/></emitter>
    </shape>
</scene>";

#[test]
fn depolarizing_scenes_have_the_same_intensity_with_and_without_polarization() {
    let document = read_text(DULL, Path::new("dull.xml"), &[]).unwrap();
    let shot = Shot::new(16);
    let scalar = Shot {
        polarized: false,
        ..shot.clone()
    };
    let [vector, scalar] =
        [shot, scalar].map(|shot| with_threads(2, &shot, &document, Duration::ZERO).0);
    for (pixel, s0) in vector.stokes.chunks(4).zip(&scalar.stokes) {
        // products of the same factors in another order: a few roundings for each of six vertices
        assert!((pixel[0] - s0).abs() <= 3e-6 * s0, "{pixel:?} {s0}");
        assert_eq!(pixel[1..], [0.0; 3]);
    }
}
