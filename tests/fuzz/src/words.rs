//! Words of each format, separated by spaces. `corpus` writes them as dictionaries, and [`crate::gltf`] puts them into JSON.

/// Keys of glTF.
pub const GLTF_KEYS: &str = r"
    asset version minVersion extensionsUsed extensionsRequired extensions scene scenes nodes children mesh camera skin
    matrix translation rotation scale name cameras type perspective yfov aspectRatio meshes primitives attributes
    indices material mode targets POSITION NORMAL TANGENT TEXCOORD_0 TEXCOORD_1 COLOR_0 materials pbrMetallicRoughness
    baseColorFactor baseColorTexture metallicFactor roughnessFactor metallicRoughnessTexture normalTexture
    occlusionTexture emissiveTexture emissiveFactor alphaMode alphaCutoff doubleSided index texCoord offset textures
    sampler source samplers magFilter wrapS wrapT images uri mimeType bufferView accessors byteOffset componentType
    normalized count sparse values bufferViews buffer byteLength byteStride buffers animations channels target node
    path pointer input output interpolation lights light color intensity range spot innerConeAngle outerConeAngle ior
    specularFactor specularColorFactor specularTexture specularColorTexture emissiveStrength EXT_texture_webp
    KHR_texture_basisu KHR_animation_pointer KHR_lights_punctual KHR_materials_emissive_strength KHR_materials_ior
    KHR_materials_specular KHR_materials_unlit KHR_mesh_quantization KHR_texture_transform EXT_mesh_gpu_instancing
    TRANSLATION ROTATION SCALE xmag ymag KHR_materials_variants variants mappings KHR_node_visibility visible MSFT_lod ids
    KHR_draco_mesh_compression EXT_meshopt_compression KHR_meshopt_compression filter fallback
    EXT_lights_image_based specularImages specularImageSize irradianceCoefficients
";

/// Texts that are values of glTF.
pub const GLTF_TEXTS: &str = r"
    2.0 2.1 1.0 SCALAR VEC2 VEC3 VEC4 MAT4 perspective orthographic LINEAR STEP CUBICSPLINE translation rotation scale
    weights pointer ATTRIBUTES TRIANGLES INDICES NONE OCTAHEDRAL QUATERNION EXPONENTIAL COLOR OPAQUE MASK BLEND point spot directional image/png image/jpeg /materials/0/emissiveFactor
    /materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength /nodes/0/translation /nodes/0/rotation
    /nodes/0/scale wall.png ./wall.jpg ../wall.png lost.png data:;base64, data:application/octet-stream;base64,AAAA
    a%20b %zz http://a/b
";

/// Keywords of OBJ and MTL, options and numbers.
pub const OBJ: &str = r"
    v vn vt vp f fo o g usemtl mtllib scene.obj p l curv surf s newmtl Kd Ke Pr Pm d Tr -halo map_Kd map_Ke map_Pr
    map_Pm norm map_Bump bump refl map_d map_Ks Ps Pc aniso off KD NEWMTL foo -q -s -o -t -mm -bm -boost -clamp on -blendu -blendv off -cc -imfchan r -type sphere
    Material #1 WALL.PNG normal.png disp decal Ka Tf illum spectral xyz
    -texres 4 wall.png wall.jpg small.webp 1/1/1 1//1 -1/-1/-1 -1 nan inf 1e38 1e-45 \ #
";

/// The tokens of TOML, and keys of plans.
pub const TOML: &str = r#"
    [[ ]] [ ] = """ ''' true false nan inf 1e400 0x 0b 1979-05-27 { } , # \u0000 [configurations] [[configurations]]
    [[sweeps]] [sweeps.over] scenes scene look_at environment reference_spp width frames fps start_time seeds
    most_seeds bounces count name preset set accumulate expect over unbiased biased any cornell path-tracing fast
    balanced accurate s1 auto restir
"#;

/// Chunks and markers of images and pictures.
pub const IMAGE: &str = r"
    IHDR PLTE IDAT IEND tRNS gAMA sRGB iCCP acTL fcTL RIFF WEBP VP8 VP8L VP8X ALPH ANIM ANMF EXIF JFIF Exif #?RADIANCE
    FORMAT=32-bit_rle_rgbe EXPOSURE= GAMMA= -Y +Y +X -X channels chlist compression dataWindow displayWindow box2i
    lineOrder pixelAspectRatio screenWindowCenter screenWindowWidth tiles tiledesc chunkCount headwater string
    stderr.R Combined.R Y RY BY
";
