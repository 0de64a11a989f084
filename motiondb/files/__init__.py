"""Files: captures of all formats become clips, clips and motions become files; sheets; folders."""
