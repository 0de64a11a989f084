"""Writers: motions, clips and scenes as BVH and glTF."""
