"""Writers of BVH and glTF."""
