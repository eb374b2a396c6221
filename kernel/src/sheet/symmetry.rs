//! Mirror planes: half and quarter models of a sheet whose yarn is alike everywhere and whose hit is centred.
//!
//! Method: of a mirrored line of N nodes the first (N + 1)/2 are modelled. The segment that crosses or leaves
//! the plane ends at an image node: of the node before the one on the plane for odd N, of the last node
//! itself for even N. An image has the displacement of its node with the sign of the component across the
//! plane turned. A node on the plane with whole mass and both neighbours moves as one with half mass and half
//! in-plane stiffness; a whole crossing segment pulls as its half whose end is fixed across the plane. Every
//! expression is the whole sheet's, and so, but for contact's order of sums, are the bits. In sums a node
//! counts as often as it has images in the whole sheet (2 or 1 along each line), likewise a segment.
//! Limits: symmetric solutions only. A whole sheet leaves symmetry by rounding soon after the first failure.
//! Reference: docs/model.md, "Symmetry planes".

use crate::body::pose::{Vector, into_body};
use crate::body::projectile::Body;
use crate::body::shape::Solid;
use crate::ground::error::{Code, Error};
use crate::scene::features::Feature;
use crate::scene::parts::{AttachmentKind, Symmetry};

/// The nodes along one direction of the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// Nodes of the whole sheet, at least 2.
    pub nodes: u32,
    /// Whether a mirror plane cuts it in the middle.
    pub mirrored: bool,
    /// Whether a segment joins its last node to its first.
    pub closed: bool,
}

impl Line {
    /// Whether a mirror plane cuts it, in a build that has them.
    pub fn is_mirrored(self) -> bool {
        Feature::Mirrors.is_built() && self.mirrored
    }

    /// Whether the line is closed, in a build that has rings.
    pub fn is_closed(self) -> bool {
        Feature::Closed.is_built() && self.closed
    }

    /// Whether an image stands after the last node modelled: of a node before a mirror plane, or of the first
    /// one.
    pub fn has_ghost(self) -> bool {
        self.is_mirrored() || self.is_closed()
    }

    /// Nodes modelled: the first half and a node on the plane.
    pub fn modelled(self) -> usize {
        let nodes = self.nodes as usize;
        if self.is_mirrored() { nodes.div_ceil(2) } else { nodes }
    }

    /// Segments modelled along the line: one from every modelled node, except the last of a line without
    /// image.
    pub fn segments(self) -> usize {
        self.stored().saturating_sub(1)
    }

    /// Places along the line: the modelled nodes, and the image after them.
    pub fn stored(self) -> usize {
        self.modelled() + usize::from(self.has_ghost())
    }

    /// The modelled node that a place shows, and whether it shows its mirror image.
    pub fn node(self, place: usize) -> (usize, bool) {
        let modelled = self.modelled();
        if self.is_mirrored() && place >= modelled {
            (modelled.saturating_sub(if self.odd() { 2 } else { 1 }), true)
        } else if self.is_closed() && place >= modelled {
            (0, false)
        } else {
            (place, false)
        }
    }

    /// Multiplicity of node i in the whole line.
    pub fn node_weight(self, i: usize) -> f64 {
        if !self.is_mirrored() || (self.odd() && i + 1 == self.modelled()) { 1.0 } else { 2.0 }
    }

    /// Multiplicity of the segment from node i in the whole line; 0 if it is itself an image of the one
    /// before.
    pub fn segment_weight(self, i: usize) -> f64 {
        match (self.is_mirrored(), i + 1 == self.modelled()) {
            (false, _) => 1.0,
            (true, false) => 2.0,
            (true, true) if self.odd() => 0.0,
            (true, true) => 1.0,
        }
    }

    /// The node before node i, across the joint of a closed line.
    pub fn before(self, i: usize) -> Option<usize> {
        if self.is_closed() && i == 0 { self.modelled().checked_sub(1) } else { i.checked_sub(1) }
    }

    fn odd(self) -> bool {
        self.nodes % 2 == 1
    }
}

impl Symmetry {
    /// 1 for the components of a force that the planes leave, 0 for those that cancel with their images.
    pub fn force_mask(self) -> Vector {
        Vector::new(kept(!self.mirror_x), kept(!self.mirror_y), 1.0)
    }

    /// 1 for the components of a torque that the planes leave, 0 for others: a plane leaves only the turning
    /// about its own normal.
    pub fn torque_mask(self) -> Vector {
        Vector::new(kept(!self.mirror_y), kept(!self.mirror_x), kept(!self.mirror_x && !self.mirror_y))
    }

    /// The images of a node or support, itself first: by which planes each is mirrored.
    pub fn images(self) -> impl Iterator<Item = [bool; 2]> {
        let all = [[false, false], [true, false], [false, true], [true, true]];
        all.into_iter().filter(move |[x, y]| (self.mirror_x || !x) && (self.mirror_y || !y))
    }

    /// 1/2 for every plane: the part of a node's weight that one image takes.
    pub fn share(self) -> f64 {
        (if self.mirror_x { 0.5 } else { 1.0 }) * (if self.mirror_y { 0.5 } else { 1.0 })
    }

    /// Refuses a body or a motion that a plane would change; takes away what rounding left of the components
    /// across the planes.
    pub fn align(self, solid: &Solid, body: &mut Body, spacing: f64) -> Result<(), Error> {
        let (force, torque) = (self.force_mask(), self.torque_mask());
        let close = |v: &Vector, mask: &Vector, scale: f64| {
            let across = v - v.component_mul(mask);
            across.norm() <= 1e-9 * scale
        };
        let q = body.orientation;
        let rotation = Vector::new(q.i, q.j, q.k);
        // Half a turn about any axis of the sheet maps a body with these planes onto itself: (w, x, y, z)
        // with one entry +-1.
        let plain = [q.w, q.i, q.j, q.k].iter().all(|&c| c * c <= 1e-18 || c * c >= 1.0 - 1e-9);
        for (sound, field, size) in [
            (close(&body.position, &force, spacing), "projectile.position", body.position.norm()),
            (close(&body.velocity, &force, body.velocity.norm()), "projectile.velocity", body.velocity.norm()),
            (plain || close(&rotation, &torque, 1.0), "projectile.orientation", rotation.norm()),
            (
                close(&body.angular_velocity, &torque, body.angular_velocity.norm()),
                "projectile.angular_velocity",
                body.angular_velocity.norm(),
            ),
        ] {
            if !sound {
                return Err(Error::new(Code::NotSymmetric, field, size, 0.0));
            }
        }
        for (mirrored, normal) in [(self.mirror_x, Vector::x()), (self.mirror_y, Vector::y())] {
            if mirrored && !solid.is_mirrored_by(&into_body(&q, &normal)) {
                return Err(Error::plain(Code::NotSymmetric, "projectile.shape"));
            }
        }
        body.position.component_mul_assign(&force);
        body.velocity.component_mul_assign(&force);
        body.angular_velocity.component_mul_assign(&torque);
        if !plain {
            let rotation = rotation.component_mul(&torque);
            (body.orientation.i, body.orientation.j, body.orientation.k) = (rotation.x, rotation.y, rotation.z);
        }
        Ok(())
    }

    /// Refuses a load, sheet's frame, that a plane would change.
    pub fn check_load(self, force: &Vector, torque: &Vector) -> Result<(), Error> {
        let loads = [(force, self.force_mask(), "external.force"), (torque, self.torque_mask(), "external.torque")];
        for (load, mask, field) in loads {
            let across = (load - load.component_mul(&mask)).norm();
            if across > 1e-9 * load.norm() {
                return Err(Error::new(Code::NotSymmetric, field, across, 0.0));
            }
        }
        Ok(())
    }
}

fn kept(keep: bool) -> f64 {
    if keep { 1.0 } else { 0.0 }
}

/// The attachment that is the image of another (numbering: [`crate::sheet::weave::attachment_of`]).
pub fn attachment_image(kind: AttachmentKind, attachment: usize, mirrored: [bool; 2]) -> usize {
    let [x, y] = mirrored;
    match kind {
        AttachmentKind::FourCorners => attachment ^ usize::from(x) ^ (usize::from(y) << 1),
        // Left and right change places by x, bottom and top by y.
        _ if attachment < 2 => attachment ^ usize::from(x),
        _ => attachment ^ usize::from(y),
    }
}

/// Image of a vector beyond these planes.
pub fn mirrored(v: &Vector, [x, y]: [bool; 2]) -> Vector {
    Vector::new(if x { -v.x } else { v.x }, if y { -v.y } else { v.y }, v.z)
}
