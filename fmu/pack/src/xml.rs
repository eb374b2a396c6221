//! XML as the project writes it: an element a line, two spaces for each level.

/// An attribute; without a value it is left out.
pub type Attribute = (&'static str, Option<String>);

/// Text of an attribute or of a page.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// The value of an attribute.
pub fn some(text: impl ToString) -> Option<String> {
    Some(text.to_string())
}

/// Name and attributes, without brackets.
pub fn tag(name: &str, attributes: &[Attribute]) -> String {
    let value = |(key, value): &Attribute| value.as_ref().map(|value| format!(" {key}=\"{}\"", escaped(value)));
    name.to_string() + &attributes.iter().filter_map(value).collect::<String>()
}

/// A text being written, and how many elements are open.
pub struct Xml {
    text: String,
    open: usize,
}

impl Xml {
    pub fn new() -> Xml {
        Xml { text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".into(), open: 0 }
    }

    pub fn line(&mut self, line: &str) {
        self.text += &format!("{}{line}\n", "  ".repeat(self.open));
    }

    /// An element with nothing in it.
    pub fn leaf(&mut self, name: &str, attributes: &[Attribute]) {
        self.line(&format!("<{}/>", tag(name, attributes)));
    }

    /// An element with those in it that the function writes.
    pub fn element(&mut self, name: &str, attributes: &[Attribute], inside: impl FnOnce(&mut Xml)) {
        self.line(&format!("<{}>", tag(name, attributes)));
        self.open += 1;
        inside(self);
        self.open -= 1;
        self.line(&format!("</{name}>"));
    }

    pub fn text(self) -> String {
        self.text
    }
}
