//! Tests of the peak memory of loading. They are a separate process that uses little memory, because the peak of a started
//! program also counts the memory of the process that starts it.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs the program, and returns the peak of its memory in bytes.
fn peak_memory(arguments: &[&str]) -> u64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_headwater"))
        .args(arguments)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
    let mut status = 0;
    // SAFETY: waits for the child just started, and fills what it is given.
    let usage = unsafe {
        libc::wait4(child.id() as i32, &raw mut status, 0, usage.as_mut_ptr());
        usage.assume_init()
    };
    // It was waited for already; this only tells the standard library.
    let _ = child.try_wait();
    assert_eq!(status, 0, "{arguments:?}");
    // Linux counts in KiB.
    usage.ru_maxrss as u64 * 1024
}

/// Writes an OBJ file of a wavy ground of 2 · `side`² triangles.
fn write_obj(path: &Path, side: u32) {
    let mut file = BufWriter::new(File::create(path).unwrap());
    let row = side + 1;
    for i in 0..row * row {
        let (x, z) = (f64::from(i % row) * 0.1, f64::from(i / row) * 0.1);
        writeln!(file, "v {x:.6} {:.6} {z:.6}", x.sin() * z.cos()).unwrap();
    }
    for i in (0..row * side).filter(|i| i % row < side) {
        let (a, b, c, d) = (i + 1, i + 2, i + row + 1, i + row + 2);
        writeln!(file, "f {a} {c} {b}\nf {b} {c} {d}").unwrap();
    }
    file.flush().unwrap();
}

#[test]
fn loading_takes_at_most_four_times_a_files_memory() {
    let triangles = match std::env::var_os("HEADWATER_TEST_ALL") {
        Some(_) => 5_000_000,
        None => 1_000_000,
    };
    let folder = tempfile::tempdir().unwrap();
    let paths = ["a.glb", "a.obj"].map(|name| folder.path().join(name));
    let [glb, obj] = paths.each_ref().map(|path| path.to_str().unwrap());
    let setting = format!("triangles={triangles}");
    peak_memory(&["scene", "generate", "terrain", "--set", &setting, "-o", glb]);
    write_obj(Path::new(obj), f64::from(triangles / 2).sqrt() as u32);
    let nothing = peak_memory(&["--help"]);
    for path in [glb, obj] {
        let size = std::fs::metadata(path).unwrap().len();
        let peak = peak_memory(&["scene", "inspect", path]);
        println!("{path}: {size} bytes, {peak} in memory, {nothing} without");
        assert!(peak <= 4 * size, "{size} bytes, {peak} in memory");
        // Or it was not the program that was measured.
        assert!(
            peak > nothing + size / 2,
            "{peak} in memory, {nothing} without"
        );
    }
}

#[test]
fn an_image_that_many_use_is_in_memory_once() {
    const USERS: usize = 40;
    let folder = tempfile::tempdir().unwrap();
    let mut png = std::io::Cursor::new(Vec::new());
    let image = image::GrayImage::new(4096, 4096);
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    std::fs::write(folder.path().join("a.png"), png.into_inner()).unwrap();
    let each = |text: &dyn Fn(usize) -> String| (0..USERS).map(text).collect::<Vec<_>>().join(",");
    let scene = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"buffers":[{{"byteLength":36,"uri":
        "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "meshes":[{{"primitives":[{}]}}],"materials":[{}],"textures":[{}],"images":[{}]}}"#,
        each(&|i| format!(r#"{{"attributes":{{"POSITION":0}},"material":{i}}}"#)),
        each(&|i| format!(r#"{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":{i}}}}}}}"#)),
        each(&|i| format!(r#"{{"source":{i}}}"#)),
        each(&|_| r#"{"uri":"a.png"}"#.to_owned()),
    );
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, scene).unwrap();
    let peak = peak_memory(&["scene", "inspect", path.to_str().unwrap()]);
    // 64 MiB when decoded.
    assert!(peak < 512 << 20, "{peak} in memory");
}

/// A zlib stream that unpacks to about `bytes` zeros. Each 13 bits of the stream unpack to 258 zeros, and its checksum is
/// missing.
fn unpacks_to_zeros(bytes: usize) -> Vec<u8> {
    // The last block, with the fixed codes; a zero; then 258 times the byte before, again and again.
    let mut bits: Vec<u8> = vec![1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0];
    for _ in 0..bytes / 258 {
        bits.extend([1, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0]);
    }
    bits.extend([0; 7]);
    let packed = (bits.chunks(8)).map(|byte| byte.iter().rev().fold(0, |sum, bit| 2 * sum + bit));
    [0x78, 0x01].into_iter().chain(packed).collect()
}

#[test]
fn colour_profiles_of_images_take_little() {
    let folder = tempfile::tempdir().unwrap();
    let mut png = std::io::Cursor::new(Vec::new());
    let image = image::GrayImage::new(1, 1);
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let mut png = png.into_inner();
    let data = [&b"iCCPa\0\0"[..], &unpacks_to_zeros(400 << 20)].concat();
    let mut chunk = (data.len() as u32 - 4).to_be_bytes().to_vec();
    chunk.extend(&data);
    chunk.extend(crc32fast::hash(&data).to_be_bytes());
    // Behind the header.
    png.splice(33..33, chunk);
    std::fs::write(folder.path().join("a.png"), png).unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(folder.path().join("a.mtl"), "newmtl a\nmap_Kd a.png\n").unwrap();
    let face = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    std::fs::write(&path, format!("mtllib a.mtl\n{face}")).unwrap();
    let peak = peak_memory(&["scene", "inspect", path.to_str().unwrap()]);
    assert!(peak < 256 << 20, "{peak} in memory");
}
