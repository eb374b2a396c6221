pub mod arrays;
pub mod image;
pub mod layout;
pub mod model;
pub mod records;
pub mod state;
pub mod system;
pub mod watch;
