//! `info`: lists the Vulkan devices, and the variant of the shaders (tracer, and access to buffers and textures) that each
//! device would use for a small scene with textures. Small means that each buffer of the scene fits into a storage buffer
//! binding of the device.

use super::{check_messages, open_vulkan, print};
use crate::Result;
use crate::base::json::value_of;
use crate::device_scene::SceneSizes;
use crate::device_scene::images::ImageSizes;
use crate::device_scene::selection::{self, Request};
use serde_json::json;

/// The command-line arguments of `headwater info`, which choose the format of the list and the device to
/// mark.
#[derive(clap::Args)]
pub struct Args {
    /// Print the devices as one JSON object instead of text
    #[arg(long)]
    json: bool,
    /// Mark the device that other commands would choose with this option: its name, a part of its name, or its index in
    /// this list; without it, the best one: discrete GPUs first, CPUs last
    #[arg(long, value_name = "NAME|INDEX", env = "HEADWATER_DEVICE")]
    device: Option<String>,
}

/// Prints the devices with their features, and the device that other commands would choose, as text or JSON.
///
/// # Errors
/// Vulkan is not installed, there is no usable device, no device has the name or index of `--device`, or the validation
/// layers have sent messages.
pub fn run(args: &Args) -> Result<()> {
    let instance = open_vulkan(crate::gpu::InstanceOptions::default())?;
    let devices = instance.devices()?;
    let (chosen, reason) = instance.choose(args.device.as_deref())?;
    let mut list = Vec::new();
    let scene = SceneSizes {
        images: ImageSizes {
            count: 1,
            ..ImageSizes::default()
        },
        ..SceneSizes::default()
    };
    for device in &devices {
        let selection = selection::select(device, Request::default(), &scene)?;
        let taken = device.index == chosen.index;
        if args.json {
            let mut entry = value_of("device", device)?;
            entry["tracer"] = json!(selection.variant.tracer.name());
            entry["tracer_reason"] = json!(selection.tracer_reason);
            entry["geometry"] = json!(selection.variant.geometry.name());
            entry["geometry_reason"] = json!(selection.geometry_reason);
            entry["fetch"] = json!(selection.variant.fetch.name());
            entry["fetch_reason"] = json!(selection.fetch_reason);
            entry["textures"] = json!(selection.variant.textures.name());
            entry["textures_reason"] = json!(selection.textures_reason);
            entry["chosen"] = json!(taken);
            list.push(entry);
            continue;
        }
        print(format_args!("{} {}", device.index, device.name))?;
        print(format_args!(
            "  kind       {}, Vulkan {}, {}",
            device.kind, device.vulkan, device.driver
        ))?;
        print(format_args!(
            "  ray query  {}; buffer addresses {}; descriptor indexing {}; subgroups of {}; timestamps {}",
            yes(device.ray_query),
            yes(device.buffer_addresses),
            yes(device.image_arrays),
            device.subgroup_size,
            yes(device.timestamp_period > 0.0)
        ))?;
        print(format_args!(
            "  memory     {} MiB; one buffer {} MiB, one binding {} MiB, texels {} MiB; {} storage buffers per shader",
            device.device_memory >> 20,
            device.max_buffer_size >> 20,
            device.max_storage_buffer_range >> 20,
            device.max_texel_bytes() >> 20,
            device.max_storage_buffers
        ))?;
        match &device.unusable {
            Some(why) => print(format_args!("  unusable   {why}"))?,
            None => {
                let variant = selection.variant;
                for (what, taken, why) in [
                    ("tracer", variant.tracer.name(), selection.tracer_reason),
                    (
                        "geometry",
                        variant.geometry.name(),
                        selection.geometry_reason,
                    ),
                    ("fetch", variant.fetch.name(), selection.fetch_reason),
                    (
                        "textures",
                        variant.textures.name(),
                        selection.textures_reason,
                    ),
                ] {
                    print(format_args!("  {what:<9}  {taken}: {why}"))?;
                }
            }
        }
        if taken {
            print(format_args!("  chosen     {reason}"))?;
        }
    }
    if args.json {
        print(format_args!(
            "{:#}",
            json!({ "devices": list, "chosen_reason": reason })
        ))?;
    }
    check_messages(&instance.validation_messages())
}

fn yes(value: bool) -> &'static str {
    if value { "yes" } else { "no" }
}
