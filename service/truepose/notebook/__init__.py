"""What `import truepose as tp` offers: the product's functions on data in memory, with answers to look at.

Every name is reached through `truepose` itself, which loads its module when it is first used.
"""
