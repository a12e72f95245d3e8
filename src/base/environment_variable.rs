//! Reads the environment variables, such as `HEADWATER_VALIDATION`, by which the user switches a function of the program
//! on.

/// True if the user asks for a function by the environment variable with the name `variable`: it is set to a value
/// other than `0`. An empty value counts as set.
pub fn is_asked_for(variable: &str) -> bool {
    std::env::var_os(variable).is_some_and(|value| value != "0")
}
