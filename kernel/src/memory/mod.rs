pub mod arrays;
pub mod layout;
pub mod model;
pub mod rows;
pub mod state;
pub mod system;
pub mod viscous_rows;
pub mod watch;
