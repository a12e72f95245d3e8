//! Studies, which measure the error and test the bias of configurations (presets with changes), so that users know which
//! settings are accurate. A study renders each configuration on several scenes with many seeds, and compares the frames with
//! path-traced references. A plan, which is a TOML file, describes the study. Every finished run is stored, so that a study
//! that was stopped can continue.

pub mod axes;
pub mod bias;
pub mod block_bias;
pub mod cell;
pub mod comparison;
pub mod costs;
pub mod exhibit;
pub mod folder;
pub mod forecast;
pub mod identity;
pub mod ledger;
pub mod library;
pub mod manifest;
pub mod outputs;
pub mod pages;
pub mod pictures;
pub mod plan;
pub mod planned_scene;
pub mod plans;
mod product;
pub mod reference;
pub mod resolved;
pub mod results;
pub mod results_text;
pub mod run;
pub mod scene_page;
pub mod shard;
pub mod store;
pub mod subject;
pub mod tidy;
pub mod work;
