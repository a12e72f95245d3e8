//! Hashes as they stand in file names, lists and messages.

/// The first 16 of a hash's hexadecimal digits: 64 bits distinguish data that were not constructed to collide.
pub fn short(hash: &blake3::Hash) -> String {
    hash.to_hex()[..16].to_owned()
}
