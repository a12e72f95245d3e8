//! `world_insert`, `world_count`, `world_scatter`, and the prefix sum between them: the lists of world reservoirs.

crate::bindings! {
    /// Bindings of the pass that puts cells into the table.
    pub struct InsertCells {
        uniform restir,
        read world_keys,
        write world_cells,
    }
}

crate::bindings! {
    /// Bindings of the pass that counts the vertices of each cell.
    pub struct CountVertices {
        uniform restir,
        write world_keys,
        write world_cells,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of the pass that enters vertices in the lists of their cells.
    pub struct ScatterVertices {
        uniform restir,
        read world_keys,
        read world_cells,
        write world_list,
        write counters,
    }
}

crate::bindings! {
    /// Bindings of both passes of a prefix sum.
    pub struct PrefixValues {
        write values,
    }
}
