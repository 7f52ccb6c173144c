"""Rules: the vocabulary, grammars in BNF, decoding of codons, and rule-sets. Pure NumPy."""

from slcs2_jax.grammar.decode import decode_rule, decode_rules, decode_words, random_rule_sets, random_rules
from slcs2_jax.grammar.grammar import GRAMMARS, Grammar, load_grammar, parse_grammar
from slcs2_jax.grammar.ruleset import Rule, RuleSets, make_rule, parse_rule_text, rule_from_mask, rule_ids

__all__ = [
    "GRAMMARS",
    "Grammar",
    "Rule",
    "RuleSets",
    "decode_rule",
    "decode_rules",
    "decode_words",
    "load_grammar",
    "make_rule",
    "parse_grammar",
    "parse_rule_text",
    "random_rule_sets",
    "random_rules",
    "rule_from_mask",
    "rule_ids",
]
