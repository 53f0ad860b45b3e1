"""Which physical effect a model lacks, with the statistics that keep the naming honest."""
