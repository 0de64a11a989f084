"""Examples that the help of every command ends with."""

from __future__ import annotations

from typer.core import TyperCommand, TyperGroup

EXAMPLES = """
motiondb add captures --words captions.tsv
motiondb add take1 take2.bvh --prefix studio2/
motiondb add cleaned --replace
motiondb show ana/walk_1 --png walk.png
motiondb quality
motiondb quality ana/walk_1 --png lacks.png --boxes needs.json
motiondb list --where 'quality > .8 and not needs'
motiondb export ana/walk_1 -o walk.bvh
motiondb export ana/walk_1 -o walk.npz
motiondb export performer=ana --as humanml3d -o set
motiondb export ana/walk_1 --from 1 --to 2.5 -o step.glb
motiondb export ana/walk_1 --loop --in-place --fps 60 --unit m -o cycle.bvh
motiondb export ana/walk_1 --onto rig.fbx -o walk_on_rig.bvh
motiondb joints rig.fbx -o rig.map
motiondb export ana/walk_1 --speed 1.2 --reduce-keys 0.5 -o walk.glb
motiondb join ana/walk_1:0-2 ana/jump_1:0.5-2.5 -o walk_jump.bvh
motiondb join ana/walk_1:0-2 ana/kick_1:1-3 -o joined.bvh
motiondb judge ana/walk_1 "walk, then kick"
motiondb judge theirs.bvh "a person jumps twice" --json
motiondb mcp --db motions.duckdb --folder captures
motiondb mcp --folder captures --folder exports --write
motiondb list --where 'performer=ana and duration>5' --sort -duration
motiondb list --csv > captures.csv
motiondb list --faulty
motiondb list --columns name,duration,licence
motiondb sql "SELECT format, count(*) FROM capture GROUP BY format"
motiondb remove ana/walk_1
motiondb remove --where 'performer=ana and caption~test'
motiondb undo
motiondb undo 12
motiondb rename walk_1 ana/walk_1
motiondb rename old/ studio1/
motiondb rename "walk_*" "ana/walk_*"
motiondb curate --share 3% --split performer -o train --as npz
motiondb curate "licence=CMU" --hours 2 --balance words --dry-run
motiondb coverage --png coverage.png
motiondb diff studio2.duckdb
motiondb merge other.duckdb --prefix studio2/
motiondb backup copy.duckdb
motiondb learn
motiondb learn --start cmu
motiondb learn --where 'performer!=16'
motiondb demo
motiondb demo --db demo.duckdb
motiondb evaluate --where 'performer=16'
motiondb symbols --png space.png
motiondb search "walk, turn left, sit down"
motiondb search "jump twice" --where performer=ana --export answers
motiondb like ana/walk_1 --from 1 --to 3
motiondb like take.bvh --by-motion-alone
motiondb along "0,0 0,2 -1.5,2"
motiondb along "0,0 0,4" --words "walk slowly" --png along.png
motiondb rhythm "0 .5 1 1.5 2" --words walk
motiondb selections add "fight day 2" ana/kick_1 boris/kick_1:0.5-1.5
motiondb selections add "fight day 2" --search kick --limit 3
motiondb selections
motiondb selections show "fight day 2"
motiondb selections take "fight day 2" boris/kick_1:0.5-1.5
motiondb selections remove "fight day 2"
motiondb selections export "fight day 2" -o pack --as glb
motiondb describe ana/walk_1
motiondb describe ana/walk_1 --gait --png gait.png
motiondb describe --where 'performer=ana' -o words.csv
motiondb compare ana/walk_1 boris/walk_1 --png both.png
motiondb batch questions.txt --json
motiondb batch questions.tsv > answers.tsv
motiondb generate "a person walks then kicks" -o walk.bvh
motiondb generate "a person jumps" -o jump.glb --variants 3
motiondb check
motiondb rescue damaged.duckdb -o saved.duckdb
motiondb info
motiondb compact
motiondb compact --motions-to /shared/motions
motiondb compact --motions-to here
motiondb serve --open
motiondb serve --read-only --port 8080
motiondb fetch cmu --subjects 14,16
motiondb tags
motiondb tags set ana/walk_1 performer=ana licence=CC0
motiondb tags set --where 'name~studio2/' performer=ben
motiondb words
motiondb words set ana/walk_1 "a person walks"
motiondb words set ana/walk_1 "turns left" --from 2 --to 3 --keep
motiondb words import captions.tsv
motiondb words export captions.csv
motiondb words export observed.csv --as boris
motiondb words history ana/walk_1
motiondb words synonyms synonyms.txt
motiondb events
motiondb events show ana/walk_1
motiondb events import events.tsv
motiondb knowledge export ours.knowledge --name ours
motiondb knowledge show cmu
motiondb grammar learn dance_1 dance_2 --name dance
motiondb grammar list
motiondb grammar show dance --png trees.png
motiondb grammar parse dance dance_3
motiondb grammar suggest dance "a b"
motiondb grammar generate dance -o new.bvh --seconds 30
motiondb grammar edit dance new --at 3 -o edited.bvh
motiondb grammar rules dance
motiondb grammar rules dance edited.txt
motiondb grammar rename dance a step_left
motiondb grammar undo dance
motiondb grammar compare dance
motiondb grammar ask dance --png questions.png
motiondb grammar ask dance --answer "a b no" --author Ana
motiondb grammar remove dance
motiondb scene grammar check basketball
motiondb scene validate basketball "dribble pass"
motiondb scene suggest basketball "dribble"
motiondb scene draw give-and-go -o diagram.png
motiondb scene make give-and-go -o scene
motiondb scene update scene changed.json
motiondb scene report scene
motiondb scene list
motiondb scene remove demo
""".strip().split("\n")


def add_examples(group: TyperCommand | TyperGroup, name: str = "motiondb") -> None:
    """Let the help of every command end with its examples."""
    for part, command in getattr(group, "commands", {}).items():
        add_examples(command, f"{name} {part}")
    own = [line for line in EXAMPLES if _is_of(line, name, group)]
    if own:
        group.epilog = "\b\nExamples:\n" + "\n".join(f"  {line}" for line in own)


def _is_of(line: str, name: str, command: TyperCommand | TyperGroup) -> bool:
    """Whether a line is an example of a command, and of none below it."""
    rest = line.removeprefix(name)
    if rest == line or (rest and not rest.startswith(" ")):
        return False
    below = getattr(command, "commands", {})
    return not below or not rest or (rest.split()[0] not in below and name != "motiondb")
