"""What passed between an arm and this program, in lines for people, as it comes, sieved."""
