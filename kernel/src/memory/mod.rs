pub mod arrays;
mod fill;
pub mod image;
pub mod layout;
pub mod model;
pub mod records;
pub mod state;
pub mod system;
pub mod watch;
