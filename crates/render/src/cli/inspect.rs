//! `brewster inspect`: what a scene holds, what its matter does to light, and what of it an image needs.

use std::path::PathBuf;
use std::process::ExitCode;

use super::values::Define;
use super::wavelengths::Wavelengths;
use super::{Failure, Outcome};
use crate::emitter::Emitter;
use crate::material::{Effect, Matter, Traits};
use crate::plan::{Plan, Request};
use crate::sampler::Generator;
use crate::scene::{self, BuiltScene, Overrides};

/// Command line of `brewster inspect`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (Mitsuba 3 XML)
    scene: PathBuf,
    /// Fill $NAME in the scene file
    #[arg(short = 'D', value_name = "NAME=VALUE")]
    define: Vec<Define>,
    #[command(flatten)]
    wavelengths: Wavelengths,
    /// Generator of the random numbers, as `brewster render` would get it
    #[arg(long, value_enum, default_value_t)]
    sampler: Generator,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let defines: Vec<(String, String)> = args
        .define
        .iter()
        .map(|d| (d.name.clone(), d.value.clone()))
        .collect();
    let wrong = |e: scene::SceneError| Failure::Usage(e.to_string());
    let document = scene::read(&args.scene, &defines).map_err(wrong)?;
    let built = scene::build(&document, Overrides::default()).map_err(wrong)?;
    let request = Request {
        mode: &args.wavelengths.mode(),
        polarized: true,
        coherence: false,
        skip: true,
    };
    super::say(&describe(&built, args.sampler, &Plan::of(&built, &request)));
    for notice in document.notices() {
        super::say(&format!("notice      {notice}\n"));
    }
    Ok(ExitCode::SUCCESS)
}

fn describe(built: &BuiltScene, generator: Generator, plan: &Plan) -> String {
    let BuiltScene {
        scene,
        camera,
        film,
        paths,
        ..
    } = built;
    let mut lines = Vec::new();
    let mut line = |topic: &str, text: String| lines.push(format!("{topic:<11} {text}"));
    line("sensor", camera.describe().to_owned());
    let [width, height] = film.size;
    line(
        "film",
        format!("{width} x {height} pixels, filter {:?}", film.filter).to_lowercase(),
    );
    if film.crop_size != film.size {
        let ([x, y], [w, h]) = (film.crop_offset, film.crop_size);
        line("", format!("cropped to {w} x {h} at {x}, {y}"));
    }
    let generator_name = clap::ValueEnum::to_possible_value(&generator)
        .map_or_else(String::new, |v| v.get_name().to_owned());
    line(
        "samples",
        format!(
            "{} a pixel (sampler '{}'), generator '{generator_name}'",
            built.samples, built.sampler
        ),
    );
    let depth = if paths.max_depth == u32::MAX {
        "without limit".to_owned()
    } else {
        paths.max_depth.to_string()
    };
    line(
        "paths",
        format!("longest {depth}, roulette beyond {}", paths.rr_depth),
    );
    let (triangles, (nodes, blocks)) = scene.size();
    line(
        "geometry",
        format!(
            "{} analytic shapes, {} meshes with {triangles} triangles; tree of {nodes} nodes, {blocks} triangle blocks",
            scene.shapes.len(),
            scene.meshes.len()
        ),
    );
    for (emitter, name) in scene.emitters.iter().zip(&built.emitter_names) {
        line("emitter", format!("{name}: {}", how_it_shines(emitter)));
    }
    if scene.emitters.is_empty() {
        line("emitter", "none: the image is black".to_owned());
    }
    let matter = scene.materials.iter().zip(&built.material_names);
    let matter: Vec<String> = matter
        .map(|(m, name)| format!("{name}: {}", what_it_does(m.effect(), m.traits())))
        .collect();
    // matter that every shape has its own copy of is told once
    for same in matter.chunk_by(|a, b| a == b) {
        line("matter", same[0].clone());
    }
    for decision in plan.decisions() {
        line(decision.verdict(), decision.to_string());
    }
    lines.join("\n") + "\n"
}

fn how_it_shines(emitter: &Emitter) -> String {
    let kinds = match emitter.polarizes() {
        (false, false) => return "unpolarized".to_owned(),
        (true, false) => "linearly",
        (false, true) => "circularly",
        (true, true) => "elliptically",
    };
    match &emitter.polarization {
        Some(p) => format!("polarized {kinds}, degree {:.4}", p.state.length()),
        None => format!("polarized {kinds}, by direction"),
    }
}

fn what_it_does(effect: Effect, traits: Traits) -> String {
    let said: Vec<&str> = [
        (
            effect.depolarizes && effect.makes_linear,
            "depolarizes in part",
        ),
        (
            effect.depolarizes && !effect.makes_linear,
            "depolarizes completely",
        ),
        (effect.makes_linear, "polarizes linearly"),
        (effect.makes_circular, "polarizes circularly"),
        (effect.retards, "retards"),
        (effect == Effect::default(), "keeps polarization"),
        (traits.coherent, "answers to coherence"),
        (traits.straight, "lets light straight through"),
        (traits.disperses, "disperses"),
        (traits.black, "reflects nothing"),
    ]
    .into_iter()
    .filter_map(|(holds, words)| holds.then_some(words))
    .collect();
    said.join(", ")
}
