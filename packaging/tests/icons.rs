//! The pictures are those of their drawings.
//!
//! `STEERWRIGHT_UPDATE=1 cargo test -p steerwright-packaging icons` draws them again.
#![allow(clippy::unwrap_used)]

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};
use std::path::{Path, PathBuf};

/// An icon's width and height, and a terminal's.
const SIDE: u32 = 128;
const TERMINAL_SIDE: u32 = 40;

fn drawings() -> Vec<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let fmus = steerwright_packaging::Fmu::ALL
        .map(|fmu| here.join("../fmu").join(fmu.folder()).join("icon.svg"));
    fmus.into_iter().chain([here.join("icons/terminal.svg")]).collect()
}

fn drawn(file: &Path) -> Pixmap {
    let tree = Tree::from_data(&std::fs::read(file).unwrap(), &Options::default()).unwrap();
    let side = if file.file_stem().unwrap() == "terminal" { TERMINAL_SIDE } else { SIDE };
    let mut picture = Pixmap::new(side, side).unwrap();
    #[allow(clippy::cast_precision_loss)]
    let scale = side as f32 / tree.size().width();
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut picture.as_mut());
    picture
}

#[test]
fn each_picture_is_drawn_from_its_svg() {
    for drawing in drawings() {
        let file = drawing.with_extension("png");
        let expected = drawn(&drawing);
        if std::env::var_os("STEERWRIGHT_UPDATE").is_some() {
            std::fs::write(&file, expected.encode_png().unwrap()).unwrap();
            continue;
        }
        let found = Pixmap::load_png(&file).unwrap();
        assert_eq!((found.width(), found.height()), (expected.width(), expected.height()));
        // Edges may come out a shade different on another processor.
        let far = found.data().iter().zip(expected.data()).filter(|(a, b)| a.abs_diff(**b) > 2);
        assert_eq!(far.count(), 0, "{} is not the drawing", file.display());
        // A picture, not a blank: several colours, and transparent at the corners.
        let colours: std::collections::BTreeSet<_> =
            found.pixels().iter().map(|p| (p.red(), p.green(), p.blue(), p.alpha())).collect();
        assert!(colours.len() > 10, "{}: {} colours", file.display(), colours.len());
        assert_eq!(found.pixel(0, 0).unwrap().alpha(), 0);
    }
}
