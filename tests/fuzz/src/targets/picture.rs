//! Pictures as `compare` and `--resume` read them: `.exr` with channels and metadata, and `.png`.

use crate::{Folder, checked, images, is_thorough};
use headwater::image::Image;
use image::ImageFormat;
use std::sync::LazyLock;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| Folder::new(&[]));

pub fn run(bytes: &[u8]) {
    let name = if images::is_exr(bytes) {
        "a.exr"
    } else {
        "a.png"
    };
    if let Some(image) = checked(Image::read(&FOLDER.write(name, bytes))) {
        let pixels = image.width as usize * image.height as usize;
        assert!(pixels > 0, "a picture has pixels");
        for name in image.channels.keys() {
            let values = image.floats(name);
            assert!(values.is_none_or(|values| values.len() == pixels));
        }
        if let Some(colors) = checked(image.colors()) {
            assert_eq!(colors.pixels.len(), pixels);
        }
        checked(image.rgb());
        if is_thorough(bytes) {
            check_writing(&image);
        }
    }
}

pub fn has_header(bytes: &[u8]) -> bool {
    match images::is_exr(bytes) {
        true => images::has_exr_header(bytes),
        false => images::has_image_header(bytes, &[ImageFormat::Png]),
    }
}

/// Checks that a picture which can be written is read again as it was.
fn check_writing(image: &Image) {
    let path = FOLDER.write("b.exr", &[]);
    if image.write(&path, 0.0).is_ok() {
        let again = Image::read(&path).expect("a picture that was written");
        assert!(again.different_channels(image).is_empty());
        assert_eq!(again.metadata, image.metadata);
    }
    if let Err(error) = image.write(&FOLDER.write("b.png", &[]), 0.0) {
        assert!(image.rgb().is_err(), "{error}");
    }
}
