//! `tone_map`: the picture as a display shows it.

crate::bindings! {
    /// Bindings of the pass.
    pub struct ToneMapPicture {
        read radiance,
        write display,
    }
}
