//! Studies: configurations × scenes × seeds × frames, compared with references, and a test for bias of each configuration. A
//! plan describes a study. Every finished run is stored, so that a study that was stopped can continue.

pub mod axes;
pub mod bias;
pub mod block_bias;
pub mod folder;
pub mod forecast;
pub mod plan;
pub mod planned_scene;
pub mod plans;
mod product;
pub mod reference;
pub mod results;
pub mod results_text;
pub mod run;
pub mod store;
pub mod subject;
pub mod work;
