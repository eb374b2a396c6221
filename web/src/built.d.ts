/** What build.mjs packs into the page. */
declare module "built:data" {
  /** Size in bytes of each structure of the C header, and offset and size of each field. */
  export const structures: Record<string, { size: number; fields: Record<string, [number, number]> }>;
  /** Keys of the scene that are whole numbers. */
  export const wholes: string[];
  /** Constants of the C header. */
  export const constants: Record<string, number>;
  /** Numbers of the preset by the key of a scene file. */
  export const preset: Record<string, number[]>;
  /** What each named fabric changes in the preset: numbers by the key of a scene file. */
  export const fabrics: Record<string, Record<string, number[]>>;
  /** Faces, mass and moments of the fragment simulator of each calibre, likewise. */
  export const fragments: Record<string, Record<string, number[]>>;
  /** Digests that every target must give (tests/golden/pins). */
  export const pinned: Record<string, string>;
  /** What `fabric run` gave for each named scene. */
  export const native: Record<string, { digest: string; endedBy: string; steps: number }>;
}

declare module "built:kernel" {
  /** The kernel for WebAssembly, gzip, base64. */
  const text: string;
  export default text;
}

declare module "built:worker" {
  /** The worker's program. */
  const text: string;
  export default text;
}
