//! Scenes in files: reads scenes from glTF and OBJ files, reads environments, and writes scenes as binary glTF.

mod environments;
pub mod export;
mod gltf;
mod hdr;
mod image_files;
mod images;
mod ktx2;
mod load;
mod obj;
mod open;
mod options;
mod polygon;
pub mod progress;
mod scene_folder;
mod surroundings;

pub use environments::environment_file_of;
pub use load::{load, load_watched};
pub use open::{check_name, file_of};
pub use options::Options;
pub use progress::{Step, Watch};
pub use surroundings::NO_ENVIRONMENT;
