//! Scenes in files: glTF, OBJ and environments are read, binary glTF is written.

mod environments;
pub mod export;
mod gltf;
mod image_files;
mod images;
mod load;
mod obj;
mod open;
mod options;
mod polygon;
pub mod progress;
mod scene_folder;

pub use environments::environment_file_of;
pub use load::{load, load_watched};
pub use open::{check_name, file_of};
pub use options::Options;
pub use progress::{Step, Watch};
