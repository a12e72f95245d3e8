//! Environments: `.exr` and `.hdr`, told apart by their first byte.

use crate::{Folder, checked, images};
use headwater::scene::Environment;
use std::sync::LazyLock;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| Folder::new(&[]));

pub fn run(bytes: &[u8]) {
    let name = if images::is_exr(bytes) {
        "a.exr"
    } else {
        "a.hdr"
    };
    let path = FOLDER.write(name, bytes);
    if let Some(environment) = checked(Environment::open(&path.to_string_lossy(), &mut Vec::new()))
    {
        let texels = environment.width as usize * environment.height as usize;
        assert_eq!(environment.texels.len(), texels);
        assert!(environment.brightest().is_finite());
        assert_eq!(environment.is_lit(), environment.brightest() > 0.0);
        let sphere: f64 = (0..environment.height)
            .map(|row| environment.solid_angle(row) * f64::from(environment.width))
            .sum();
        assert!((sphere / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-6);
        assert_eq!(environment.means().len(), texels);
    }
}

pub fn has_header(bytes: &[u8]) -> bool {
    match images::is_exr(bytes) {
        true => images::has_exr_header(bytes),
        false => images::has_hdr_header(bytes),
    }
}
