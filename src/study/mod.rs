//! Studies: configurations × scenes × seeds × frames against references, with a test for bias of each configuration. A plan
//! describes a study; every finished run is kept, so that a stopped study can continue.

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
