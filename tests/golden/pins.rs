//! Digests of the golden scenes. Changing one is a changelog entry that says why the bits changed.

pub const SHEET_3IN_SPHERE: u64 = 0x455c_5111_14a1_c4cd;
pub const SHEET_10IN_CYLINDER: u64 = 0x3b5c_dc15_9b3d_4ee9;
pub const UNIFORM_SPHERE_BEFORE_FAILURE: u64 = 0xbce0_3547_ba2a_87f4;
pub const UNIFORM_SPHERE_THROUGH_FAILURE: u64 = 0x3454_d6d2_e5f0_4ab3;
pub const TUMBLING_CYLINDER_ON_CORNERS: u64 = 0xdb19_8708_2bbc_1b97;
pub const FREE_PLIES_IN_A_TURNED_FRAME: u64 = 0x406d_ce46_c616_1236;
pub const DAMAGE_LAW_WITH_OFFSET: u64 = 0xd669_f7b9_cfff_c595;
pub const LOADED_SPHERE_ON_A_PREPARED_SHEET: u64 = 0x0c23_f514_6c2c_cf56;
pub const PRESCRIBED_CYLINDER_ON_TWO_PATHS: u64 = 0xe773_3e95_6f79_1c4a;
pub const TUMBLING_BULLET: u64 = 0x9ec6_68c6_e330_f937;
pub const BOX_ON_A_CORNER: u64 = 0x2b59_1605_0126_5a25;
pub const DISC_SECTOR: u64 = 0x9974_0c30_a7d9_18fa;
pub const QUARTER_UNDER_A_CYLINDER: u64 = 0xadb4_4a1b_3533_e880;
pub const DRAWN_YARNS_BY_THE_THETA_RULE: u64 = 0xebd2_bf2c_8896_7444;
pub const SPHERE_ON_BALANCED_YARN: u64 = 0xd291_1392_8b8f_74b5;
pub const SPHERE_ON_DRAWN_STRENGTH: u64 = 0x5659_d82a_f343_603f;
pub const TAUT_WARP_AND_CRIMPED_WEFT: u64 = 0xcfc3_cd1f_4149_1736;
pub const SPHERE_THAT_RUBS: u64 = 0x1517_f891_56b2_676e;
pub const SPHERE_ON_VISCOUS_YARN: u64 = 0x6c64_e506_1bcd_260a;
pub const SPHERE_ON_YARN_THAT_DEPENDS_ON_RATE: u64 = 0x2d72_3626_93ad_05c9;
pub const SPHERE_THROUGH_TURNED_PLIES: u64 = 0xe7d8_21b5_a00b_a868;
pub const CYLINDER_ON_A_GRADED_SHEET: u64 = 0xd578_80a2_c4b6_8425;
