//! The recipes of the procedural scenes: their parameters, and the functions that generate the scenes from them. There is
//! one file for each family of scenes.

mod atrium;
mod city_grid;
mod colourful_mess;
mod conservatory;
mod cornell;
mod divided_room;
mod extremes;
mod figures;
mod furnace;
mod garage;
mod glass;
mod motion;
mod night_city;
mod statue_room;
mod street;
mod terrain;
mod two_rooms;

use super::Procedural;

/// All procedural scenes, in the order in which `headwater scene list` prints them. A scene that is named on the command
/// line is looked up in this list.
pub const SCENES: &[Procedural] = &[
    Procedural {
        name: "atrium",
        description: "Two storeys of arcades around a court; three small lamps, mostly out of sight",
        parameters: atrium::PARAMETERS,
        make: atrium::make,
    },
    Procedural {
        name: "colourful-mess",
        description: "A heap of coloured toys, matte, glossy and of metal, among coloured lamps",
        parameters: colourful_mess::PARAMETERS,
        make: colourful_mess::make,
    },
    Procedural {
        name: "conservatory",
        description: "A room with one of everything: textures, alpha, vertex colours, all kinds of light",
        parameters: conservatory::PARAMETERS,
        make: conservatory::make,
    },
    Procedural {
        name: "city-grid",
        description: "City blocks at night from above, street lamps along every pavement",
        parameters: city_grid::PARAMETERS,
        make: city_grid::make,
    },
    Procedural {
        name: "cornell",
        description: "The box: matte red, green and white walls, two blocks, one lamp",
        parameters: cornell::PARAMETERS,
        make: cornell::plain,
    },
    Procedural {
        name: "cornell-glossy",
        description: "The box with metal spheres of roughness .1, .3 and .6 and a dielectric block",
        parameters: cornell::GLOSSY_PARAMETERS,
        make: cornell::glossy,
    },
    Procedural {
        name: "divided-room",
        description: "A room with a wall across it: the lamps that the camera sees are dim, the one behind the wall is bright",
        parameters: divided_room::PARAMETERS,
        make: divided_room::make,
    },
    Procedural {
        name: "extremes",
        description: "The corner of a room with a ball and two lamps; each parameter takes one quantity to its limit",
        parameters: extremes::PARAMETERS,
        make: extremes::make,
    },
    Procedural {
        name: "figures",
        description: "Spheres, cones and chessmen on a plane under many coloured lights",
        parameters: figures::PARAMETERS,
        make: figures::make,
    },
    Procedural {
        name: "furnace",
        description: "A room of uniform light around one convex body, which cannot be seen if it reflects all light",
        parameters: furnace::PARAMETERS,
        make: furnace::make,
    },
    Procedural {
        name: "garage",
        description: "A garage with a small car, a workbench, shelves and a bronze bust, under five lamps",
        parameters: garage::PARAMETERS,
        make: garage::make,
    },
    Procedural {
        name: "glass",
        description: "A chequered floor under a wide lamp, and something of glass: a ball, a sheet, or a block around the camera",
        parameters: glass::PARAMETERS,
        make: glass::make,
    },
    Procedural {
        name: "motion",
        description: "A playroom in which camera, toys and lamps move and a sign goes on and off",
        parameters: motion::PARAMETERS,
        make: motion::make,
    },
    Procedural {
        name: "night-city",
        description: "A wet street at night: thousands of lamps, windows and signs",
        parameters: night_city::PARAMETERS,
        make: night_city::make,
    },
    Procedural {
        name: "statue-room",
        description: "A marble bust in a niche, under one lamp",
        parameters: statue_room::PARAMETERS,
        make: statue_room::make,
    },
    Procedural {
        name: "street",
        description: "An old street on a festival night: paper lanterns, lit windows, market stalls",
        parameters: street::PARAMETERS,
        make: street::make,
    },
    Procedural {
        name: "terrain",
        description: "A height field under a low sun, of any number of triangles",
        parameters: terrain::PARAMETERS,
        make: terrain::make,
    },
    Procedural {
        name: "two-rooms",
        description: "Two rooms and a door ajar in the thin wall between: all light is in the room behind",
        parameters: two_rooms::PARAMETERS,
        make: two_rooms::make,
    },
];
